"""A stored result as a program opens it: what was written comes back, and what is none is refused."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from pathlib import Path

import garmentq
import numpy as np
import pytest
import trimesh
from garmentq.core.deliver.export.result import write_recovery
from garmentq.core.deliver.export.stored_result import FILES
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.run.errors import GarmentqError
from PIL import Image

PAGE = Path(__file__).parents[2] / "docs" / "tutorials" / "notebook.md"


@pytest.fixture(scope="module")
def folder(tube_recovery, tmp_path_factory) -> Path:
    """Return the folder of a written recovery, below that of a person."""
    made = tmp_path_factory.mktemp("person") / "result" / "upper"
    write_recovery(tube_recovery(), made)
    return made


def test_what_was_written_comes_back(folder: Path, tube_recovery) -> None:
    """Fails if a mesh were another one's, a vertex moved, or the pattern not the one in the file."""
    recovery, result = tube_recovery(), garmentq.open_result(folder)
    assert result.meshes == ("graded", "detail") and result.name == "garment"
    assert np.array_equal(result.mesh("detail").vertices, recovery.meshes.detail)
    read = trimesh.load(folder / "detail.ply", process=False)
    assert np.array_equal(result.mesh("detail").vertices, read.vertices)
    assert np.array_equal(result.mesh("detail").faces, read.faces)
    assert json.loads(json.dumps(write_pattern(result.pattern))) == json.loads((folder / "pattern.json").read_text())
    assert result.fabric == recovery.fabric and result.manifest["seed"] == 0
    assert np.array_equal(result.body.vertices, recovery.body.vertices)
    assert result.metrics == json.loads((folder / "metrics.json").read_text())


def test_a_notebook_shows_the_picture(folder: Path, tmp_path: Path) -> None:
    """Fails if there were nothing that a notebook knows how to show, or one of its three parts were empty."""
    result = garmentq.open_result(str(folder))
    png = result.plot()._repr_png_()
    assert png == result.plot("detail").png != result.plot("graded").png
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("L"))
    for part in np.array_split(pixels, 3, axis=1):
        assert 0.02 < np.mean(part < 250) < 0.98
    assert result.plot().save(tmp_path / "a.png").read_bytes() == png


def test_what_a_notebook_prints_is_one_line(folder: Path) -> None:
    """Fails if a name at the end of a notebook's cell filled pages with arrays."""
    result = garmentq.open_result(folder)
    mesh = result.mesh("detail")
    shown = (result, result.pattern, result.pattern.panels[0], result.body, result.worn, mesh, mesh.garment)
    for one in (*shown, result.fabric):
        assert len(repr(one)) < 400 and "\n" not in repr(one) and "array(" not in repr(one), repr(one)[:200]
    assert repr(result) == "<StoredResult garment: 2 panels, meshes graded, detail>"


@pytest.mark.parametrize(
    ("open_it", "code", "word"),
    [
        (lambda f: garmentq.open_result(f).mesh("nosuch"), "result.mesh_unknown", "graded, detail"),
        (lambda f: garmentq.open_result(f.parent), "result.unreadable", "upper"),
        (lambda f: garmentq.open_result(f / "nosuch"), "result.unreadable", "garmentq export"),
        (lambda f: garmentq.open_result("3685ecfd4f81", home=f.parents[1] / "home"), "job.unknown", "3685ecfd4f81"),
        (lambda f: garmentq.open_result("http://127.0.0.1:9/results/3685ecfd4f81"), "service.unreachable", "127.0.0.1"),
    ],
)
def test_what_is_no_result_is_refused(folder: Path, open_it, code: str, word: str) -> None:
    """Fails if a wrong name ended in a traceback, or the message named no next step."""
    with pytest.raises(GarmentqError, match=word) as caught:
        open_it(folder)
    assert caught.value.code == code


def test_a_damaged_result_is_refused(folder: Path, tmp_path: Path) -> None:
    """Fails if half a file were read as a whole one."""
    for name in ("worn.npz", "metrics.json", "detail.ply"):
        broken = tmp_path / name.replace(".", "_")
        broken.mkdir()
        for file in (folder / kept for kept in FILES if (folder / kept).exists()):
            cut = file.read_bytes()
            (broken / file.name).write_bytes(cut[: len(cut) // 4] if file.name == name else cut)
        with pytest.raises(GarmentqError):
            garmentq.open_result(broken)


def test_the_packages_door_is_light() -> None:
    """Fails if `import garmentq` loaded numpy, or hid a misspelt name."""
    code = "import sys, garmentq; print('numpy' in sys.modules, hasattr(garmentq, 'nosuch'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


def test_the_page_runs(folder: Path, monkeypatch) -> None:
    """Fails if a line of the documented page did not run as it stands."""
    (folder.parents[1] / "demo").symlink_to(folder.parents[1], target_is_directory=True)
    monkeypatch.chdir(folder.parents[1])
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) >= 3
    cells: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), cells)
    assert (folder.parents[1] / "upper.png").is_file()
