"""The wheel holds what the tree holds, the source archive what the wheel is made of; an installed wheel runs."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

import garmentq
import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("core", "service", "workers", "cli", "migrations")
DATA = {".npz", ".json", ".html", ".css", ".js", ".svg", ".txt", ".mako", ".ini", ".py", ".typed"}
LEFT_OUT = {"__pycache__"}
BUILT_FROM = ("pyproject.toml", "setup.py", "MANIFEST.in", "__init__.py", "py.typed")
READ = ("LICENSE", "README.md", "CHANGELOG.md", "SECURITY.md", "constraints.txt")
LOOSE = (*BUILT_FROM, *READ)
MADE_BY_BUILDS = {"PKG-INFO", "setup.cfg"}
MAX_ARCHIVE_SIZE = 8_000_000
"""Of wheel and source archive, each [B]: the body's asset is a quarter of it; a scan that strays in would be more."""


def copy_tree(destination: Path) -> None:
    """Copy what a build needs, as a fresh clone would have it."""
    for name in LOOSE:
        shutil.copy(ROOT / name, destination / name)
    for name in (*ROOMS, "tests", "docs", "examples", "benchmarks"):
        if (ROOT / name).exists():
            ignored = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc", ".*", "*.ply", "*.obj")
            shutil.copytree(ROOT / name, destination / name, ignore=ignored)


def build(folder: Path, kind: str) -> Path:
    """Build a wheel or a source archive (sdist) as `pip` and `python -m build` do, and return its file."""
    (folder / "dist").mkdir(exist_ok=True)
    code = f"from setuptools import build_meta; print('built', build_meta.build_{kind}('dist'))"
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return folder / "dist" / done.stdout.rpartition("built ")[2].strip()


def list_contents(wheel: Path) -> dict[str, int]:
    """Return the check sums of a wheel's files by their names, without those about the archive itself."""
    with zipfile.ZipFile(wheel) as archive:
        return {one.filename: one.CRC for one in archive.infolist() if not one.filename.endswith("/RECORD")}


def run_python(environment: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the Python of an environment away from the checkout, with nothing of this process's environment but PATH."""
    return subprocess.run(
        [environment / "bin" / "python", *arguments], cwd=environment, capture_output=True, text=True, check=False,
        env={"PATH": os.environ["PATH"], "HOME": str(environment)},
    )  # fmt: skip


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Build the wheel of a copy of the tree, which lies beside it."""
    folder = tmp_path_factory.mktemp("tree")
    copy_tree(folder)
    return build(folder, "wheel")


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    """Build the source archive of a copy of the tree, and unpack it."""
    folder = tmp_path_factory.mktemp("source")
    copy_tree(folder)
    archive = build(folder, "sdist")
    assert archive.stat().st_size <= MAX_ARCHIVE_SIZE
    with tarfile.open(archive) as opened:
        opened.extractall(folder / "unpacked", filter="data")
    (unpacked,) = (folder / "unpacked").iterdir()
    return unpacked


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


@pytest.mark.slow
def test_the_source_archive_gives_the_same_wheel(wheel, source):
    """Broken where the source archive lacks a file that the wheel is made of, or ships tests, examples or pages."""
    shipped = {path.relative_to(source) for path in source.rglob("*") if path.is_file()}
    loose = {path.name for path in shipped if len(path.parts) == 1}
    assert loose == {*LOOSE, *MADE_BY_BUILDS}
    assert {path.parts[0] for path in shipped if len(path.parts) > 1} == {*ROOMS, "garmentq.egg-info"}
    assert list_contents(build(source, "wheel")) == list_contents(wheel)
    assert wheel.stat().st_size <= MAX_ARCHIVE_SIZE


READ_DATA = """
import garmentq
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.motion.shipped import SHIPPED_MOTIONS, find_shipped_motion
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.garment.templates import list_templates, load_draped_template, load_template
from garmentq.core.people.networks import load_ensemble
from garmentq.service.pages.static_files import FOLDER, VENDORED

assert builtin_body("builtin:male,height=1.80").vertices.shape[1] == 3
assert get_fabric("denim").k > 0.0 and load_ensemble().networks
assert all(load_template(one.name).panels for one in list_templates())
assert load_draped_template("skirt") is not None and any((FOLDER / VENDORED).glob("three-*.js"))
assert all(find_shipped_motion(name).is_file() for name in SHIPPED_MOTIONS)
print(garmentq.__file__)
"""
"""What a recovery reads of the package's own files."""


@pytest.mark.nightly
def test_an_installed_wheel_runs(source, tmp_path):
    """Broken where the package works in a checkout alone: a file, the command or its version is missing elsewhere."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "venv"], check=True)
    environment = tmp_path / "venv"
    pip = [sys.executable, "-m", "pip", "--python", environment / "bin" / "python", "--quiet"]
    subprocess.run([*pip, "install", "--no-deps", "--no-index", build(source, "wheel")], check=True)
    (place,) = (environment / "lib").glob("python3*/site-packages")
    (place / "others.pth").write_text(sysconfig.get_paths()["purelib"])
    command = str(environment / "bin" / "garmentq")
    assert run_python(environment, command, "--version").stdout == f"garmentq, version {garmentq.__version__}\n"
    for words in (["doctor"], ["db", "upgrade"], ["templates", "list"], ["materials"]):
        done = run_python(environment, command, *words)
        assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
    done = run_python(environment, "-c", READ_DATA)
    assert done.returncode == 0 and str(environment) in done.stdout, done.stderr


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
