"""The wheel holds what the tree holds: nothing is left out, nothing strays in."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("core", "service", "workers", "cli", "migrations")
DATA = {".npz", ".json", ".html", ".css", ".js", ".svg", ".txt", ".mako", ".ini", ".py", ".typed"}
LEFT_OUT = {"__pycache__"}


def copy_tree(destination: Path) -> None:
    """Copy what a build needs, as a fresh clone would have it."""
    for name in ("pyproject.toml", "setup.py", "LICENSE", "README.md", "__init__.py", "constraints.txt"):
        if (ROOT / name).exists():
            shutil.copy(ROOT / name, destination / name)
    if not (destination / "README.md").exists():
        (destination / "README.md").write_text("# garmentq\n")
    for name in (*ROOMS, "tests", "docs", "examples", "benchmarks"):
        if (ROOT / name).exists():
            ignored = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc", ".*", "*.ply", "*.obj")
            shutil.copytree(ROOT / name, destination / name, ignore=ignored)


@pytest.mark.slow
def test_the_wheel_equals_the_tree(tmp_path):
    """Broken where a new folder, a template, the body's asset or a migration is not shipped, or tests are."""
    copy_tree(tmp_path)
    (tmp_path / "dist").mkdir()
    code = "from setuptools import build_meta; build_meta.build_wheel('dist')"  # what pip calls
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        shipped = {name for name in archive.namelist() if ".dist-info/" not in name}
    expected = {"garmentq/__init__.py"} | {
        f"garmentq/{path.relative_to(tmp_path).as_posix()}"
        for room in ROOMS
        for path in (tmp_path / room).rglob("*")
        if path.is_file() and path.suffix in DATA and not LEFT_OUT & set(path.parts)
    }
    assert shipped == expected
    strays = {
        path.relative_to(tmp_path).as_posix()
        for room in ROOMS
        for path in (tmp_path / room).rglob("*")
        if path.is_file() and path.suffix not in DATA
    }
    assert strays == set(), "a kind of file that setup.py does not ship"
    assert "garmentq/migrations/versions/0001_initial.py" in shipped
    assert "garmentq/migrations/script.py.mako" in shipped
