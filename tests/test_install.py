"""The image's own install commands, run in an empty environment: what production gets, and that it works."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TOOLS = {"pip", "setuptools"}
"""What the environment itself brings."""


def normalise(name: str) -> str:
    """Return a package's name as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


@pytest.fixture(scope="module")
def environment() -> Iterator[tuple[Path, dict[str, str]]]:
    """Install as the Dockerfile does into a fresh environment; gives its `bin` and the variables to run with."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory(prefix="gq-install-") as folder:
        place = Path(folder)
        rooms = ("core", "service", "workers", "cli", "migrations")
        for name in rooms:
            shutil.copytree(ROOT / name, place / "src" / name, ignore=shutil.ignore_patterns("__pycache__", "*.nb[ic]"))
        for path in (path for path in ROOT.iterdir() if path.is_file()):
            shutil.copy(path, place / "src")
        (place / "src" / "deploy").mkdir()
        shutil.copy(ROOT / "deploy" / "prune.py", place / "src" / "deploy")
        subprocess.run([sys.executable, "-m", "venv", place / "venv"], check=True)
        found = place / "venv" / "bin"
        index = re.search(r"^ARG TORCH_INDEX=(\S+)$", text, re.MULTILINE)[1]
        kept = {name: value for name, value in os.environ.items() if name.startswith(("PIP_", "SSL_", "HTTP", "NO_PR"))}
        variables = kept | {"PATH": f"{found}:/usr/bin:/bin", "HOME": folder, "GARMENTQ_HOME": f"{folder}/home"}
        variables |= {"TORCH_INDEX": os.environ.get("TORCH_INDEX", index), "OMP_NUM_THREADS": "1", "COLUMNS": "200"}
        for command in re.findall(r"^RUN (pip install .+)$", text, re.MULTILINE):
            done = subprocess.run(command, shell=True, cwd=place / "src", env=variables, capture_output=True, text=True)
            if "torch" in command and "No matching distribution" in done.stderr:
                pytest.skip(f"no torch at {variables['TORCH_INDEX']}")
            assert done.returncode == 0, f"{command}\n{done.stderr[-2000:]}"
        yield found, variables


def run(environment: tuple[Path, dict[str, str]], *words: str) -> str:
    """Run a program of the environment outside the checkout, and return what it says."""
    found, variables = environment
    words = (str(found / words[0]), *words[1:])
    done = subprocess.run(words, cwd=variables["HOME"], env=variables, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.mark.nightly
def test_production_is_the_lock_and_nothing_else(environment):
    """Broken where a hash is wrong, a package is missing from the lock, or a tool of ours is in production."""
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    locked = {normalise(name) for name in re.findall(r"^([A-Za-z0-9._-]+)==", lock, re.MULTILINE)}
    listed = json.loads(run(environment, "pip", "list", "--format", "json"))
    assert {normalise(one["name"]) for one in listed} - TOOLS == (locked | {"torch", "garmentq"}) - TOOLS
    assert "No broken requirements" in run(environment, "pip", "check")
    [package] = environment[0].parent.glob("lib/python*/site-packages/garmentq")
    assert {path.name for path in package.iterdir() if path.is_file()} == {"__init__.py", "py.typed"}
    assert {path.name for path in (package.parent / "igl").iterdir()}.isdisjoint({"copyleft", "triangle"})


@pytest.mark.nightly
def test_production_recovers_a_garment(environment):
    """Broken where a command needs a package that only the tests bring."""
    assert run(environment, "garmentq", "--version").startswith("garmentq, version ")
    run(environment, "garmentq", "doctor")
    data = ROOT / "examples" / "data"
    garment = [str(data / "garment.ply"), "--body", str(data / "body.ply"), "--vertices", "500"]
    try:
        run(environment, "garmentq", "run", *garment, "--out", "result", "--lenient")
    finally:
        run(environment, "garmentq", "down")
    assert (Path(environment[1]["HOME"]) / "result" / "pattern.json").exists()
