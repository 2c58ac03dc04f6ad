"""Target packs: what is read, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from garmentq.cli.bench.packs import read_packs, read_true_mesh, read_true_pattern
from garmentq.core.run.errors import BadInput, NotFound


def make_pack(folder: Path, name: str, **files: str) -> Path:
    """Write a pack of a single triangle; keyword arguments add files (`_` for the dot)."""
    pack = folder / name
    pack.mkdir(parents=True)
    (pack / "meta.json").write_text(json.dumps({"name": name, "category": "skirt"}))
    (pack / "garment.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 1 0\n3 0 1 2\n"
    )
    for file, text in files.items():
        (pack / file.replace("_", ".")).write_text(text)
    return pack


def test_packs_are_found_in_the_order_of_their_names(tmp_path: Path) -> None:
    """Fails if a folder without meta.json counted, or a scan pack were not told apart."""
    make_pack(tmp_path, "b", body_ply="x", template_json="{}")
    make_pack(tmp_path, "a", scan_ply="x")
    (tmp_path / "notes").mkdir()
    first, second = read_packs(tmp_path)
    assert (first.name, first.body, first.template, first.labels) == ("a", None, None, None)
    assert first.scan is not None and first.scan.name == "scan.ply"
    assert (second.name, second.scan, second.category) == ("b", None, "skirt")
    assert second.body is not None and second.template is not None
    assert [pack.name for pack in read_packs(tmp_path, ("b",))] == ["b"]
    assert [pack.name for pack in read_packs(tmp_path / "b")] == ["b"]


def test_wrong_folders_and_names_are_refused_with_a_code(tmp_path: Path) -> None:
    """Fails if an empty folder meant zero targets and success."""
    with pytest.raises(NotFound) as missing:
        read_packs(tmp_path)
    assert missing.value.code == "bench.no_packs"
    make_pack(tmp_path, "a")
    with pytest.raises(NotFound) as unknown:
        read_packs(tmp_path, ("a", "z"))
    assert unknown.value.code == "bench.unknown_pack"
    assert "'z'" in unknown.value.message


def test_the_true_mesh_is_read_as_it_is(tmp_path: Path) -> None:
    """Fails if the truth were repaired: its doubled vertex stays."""
    pack = read_packs(make_pack(tmp_path, "a"))[0]
    vertices, faces = read_true_mesh(pack)
    assert vertices.shape == (4, 3) and faces.tolist() == [[0, 1, 2]]
    pack.garment.write_text("ply\nformat ascii 1.0\nelement vertex 400\nend_header\n")
    with pytest.raises(BadInput):
        read_true_mesh(pack)


def test_the_true_pattern(tmp_path: Path) -> None:
    """Fails if edges, stitches or the unit were misread, or a broken file gave a traceback."""
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    edges = [[square[i], square[(i + 1) % 4]] for i in range(4)]
    data = {
        "unit": "m",
        "panels": {"a": {"outline": square, "edges": edges}, "b": {"outline": square, "holes": []}},
        "stitches": [{"a": ["a", 1], "b": ["a", 3], "reversed": True}],
    }
    pack = read_packs(make_pack(tmp_path, "a", pattern_json=json.dumps(data)))[0]
    truth = read_true_pattern(pack)
    assert truth is not None
    assert [panel.name for panel in truth.panels] == ["a", "b"]
    assert np.array_equal(truth.panels[0].edges[3], [[0, 1], [0, 0]])
    assert truth.panels[1].edges == ()
    assert (truth.seams[0].a, truth.seams[0].b) == (("a", 1), ("a", 3))
    for broken in ("[]", "{", '{"unit": "cm", "panels": {}}', '{"unit": "m", "panels": {"a": {"outline": [[0]]}}}'):
        (pack.folder / "pattern.json").write_text(broken)
        with pytest.raises(BadInput):
            read_true_pattern(pack)
    (pack.folder / "pattern.json").unlink()
    assert read_true_pattern(pack) is None
