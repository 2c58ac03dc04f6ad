"""The wheel holds what the tree holds: nothing is left out, nothing strays in."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("core", "service", "workers", "cli", "migrations")
DATA = {".npz", ".json", ".html", ".css", ".js", ".svg", ".txt", ".mako", ".ini", ".py", ".typed"}
LEFT_OUT = {"__pycache__"}


def copy_tree(destination: Path) -> None:
    """Copy what a build needs, as a fresh clone would have it."""
    for name in ("pyproject.toml", "setup.py", "LICENSE", "README.md", "__init__.py", "py.typed", "constraints.txt"):
        if (ROOT / name).exists():
            shutil.copy(ROOT / name, destination / name)
    if not (destination / "README.md").exists():
        (destination / "README.md").write_text("# garmentq\n")
    for name in (*ROOMS, "tests", "docs", "examples", "benchmarks"):
        if (ROOT / name).exists():
            ignored = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc", ".*", "*.ply", "*.obj")
            shutil.copytree(ROOT / name, destination / name, ignore=ignored)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Build the wheel of a copy of the tree, which lies beside it."""
    folder = tmp_path_factory.mktemp("tree")
    copy_tree(folder)
    (folder / "dist").mkdir()
    code = "from setuptools import build_meta; build_meta.build_wheel('dist')"  # what pip calls
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    (built,) = (folder / "dist").glob("*.whl")
    return built


@pytest.mark.slow
def test_the_wheel_equals_the_tree(wheel):
    """Broken where a new folder, a template, the body's asset or a migration is not shipped, or tests are."""
    tmp_path = wheel.parents[1]
    with zipfile.ZipFile(wheel) as archive:
        shipped = {name for name in archive.namelist() if ".dist-info/" not in name}
    expected = {"garmentq/__init__.py", "garmentq/py.typed"} | {
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
    assert "garmentq/py.typed" in shipped, "or no type checker looks into the package"


SCRIPT = """
import garmentq
from garmentq.service.client import Client

result = garmentq.open_result("folder")
reveal_type(result)
reveal_type(result.pattern.panels[0].name)
reveal_type(result.mesh("detail").vertices)
with Client("http://127.0.0.1:8080", key="x") as service:
    reveal_type(service.find_job("3685ecfd4f81").state)
    reveal_type(service.mend_labels)
"""
"""A user's script."""

TYPES = (
    "garmentq.core.deliver.export.stored_result.StoredResult", "str", "numpy.ndarray", "garmentq.service.states.State",
    "garmentq.service.submission.SubmissionResult",
)  # fmt: skip
"""What is revealed in it, line by line."""


@pytest.mark.nightly
def test_an_installed_package_has_types(wheel, tmp_path):
    """Broken where a user's type checker finds no types in the package, and takes all of it for `Any`."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv"], check=True)
    (place,) = (tmp_path / "venv" / "lib").glob("python3*/site-packages")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place)
    (place / "others.pth").write_text(sysconfig.get_paths()["purelib"])
    (tmp_path / "script.py").write_text(SCRIPT)
    asked = ["--config-file=", f"--cache-dir={tmp_path / 'cache'}", "--follow-imports=silent", "script.py"]
    command = [sys.executable, "-m", "mypy", "--python-executable", tmp_path / "venv" / "bin" / "python", *asked]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env={"PATH": os.environ["PATH"]})
    revealed = [line for line in done.stdout.splitlines() if "Revealed type" in line]
    assert done.returncode == 0 and len(revealed) == len(TYPES), done.stdout + done.stderr
    for line, wanted in zip(revealed, TYPES, strict=True):
        assert wanted in line and '"Any"' not in line, line


def test_what_is_loaded_late_is_listed():
    """Broken where Tab in a notebook does not offer `open_result`, which `from garmentq import *` gives."""
    module = importlib.import_module("garmentq")
    assert set(module.__all__) <= set(dir(module))
