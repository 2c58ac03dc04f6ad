"""The lock file is whole: every production package once, with a hash, at the version that the suite was run with."""

from __future__ import annotations

import importlib.util
import json
import re
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]


def load_supply():
    """Load the script that writes lock and list."""
    spec = importlib.util.spec_from_file_location("supply", ROOT / "deploy" / "supply.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def normalise(name):
    """Return a package's name as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def read_versions(path):
    """Return name and version of each line that pins a package."""
    found = re.findall(r"^([A-Za-z0-9._-]+)==([^ \n]+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {normalise(name): version for name, version in found}


def test_the_lock_pins_what_was_tested():
    """Broken where a dependency is added and the lock forgotten, or production gets another version than the suite."""
    locked, tested = read_versions(ROOT / "requirements.lock"), read_versions(ROOT / "constraints.txt")
    lines = [line for line in (ROOT / "requirements.lock").read_text().splitlines() if line[:1] not in ("#", "-", "")]
    assert len(lines) == len(locked) and all(re.search(r"--hash=sha256:[0-9a-f]{64}$", line) for line in lines)
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8").split("[project.optional-dependencies]")[0]
    needed = re.findall(r'^    "([A-Za-z0-9_-]+)[^"]*?"', project.split("dependencies = [")[1], re.MULTILINE)
    names = {name.lower().replace("_", "-") for name in needed} - {"open3d", "torch"}
    assert names <= set(locked), names - set(locked)
    assert {n: locked[n].split("+")[0] for n in locked if n in tested} == {n: tested[n] for n in locked if n in tested}
    assert not {"pytest", "mypy", "ruff", "moto", "hypothesis", "schemathesis"} & set(locked), "no tools in production"


@pytest.mark.parametrize("python", ["3.11.0", "3.11.15"])
def test_every_patch_release_of_python_finds_what_it_needs(python):
    """Broken where what a package asks of an earlier Python alone is not in the lock: it is installed without."""
    locked = read_versions(ROOT / "requirements.lock")
    asked = {}
    for name in locked:
        try:
            lines = requires(name) or []
        except PackageNotFoundError:  # of an extra that this environment has not
            continue
        for one in map(Requirement, lines):
            if one.marker is None or one.marker.evaluate({"python_full_version": python, "extra": ""}):
                asked[normalise(one.name)] = name
    missing = {name: by for name, by in asked.items() if name not in locked and name != "torch"}
    assert len(asked) > 50 and not missing


def test_the_list_has_every_package():
    """Broken where a package is left out of what an auditor gets."""
    supply = load_supply()
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    listed = json.loads(supply.write_list(lock))
    apart = {"torch": read_versions(ROOT / "constraints.txt")["torch"]}
    found = {one["name"]: one["version"] for one in listed["components"]}
    assert found == read_versions(ROOT / "requirements.lock") | apart
    docker = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    assert "--require-hashes --no-deps -r requirements.lock" in docker, "the image has other packages than the lock"
    archive = {"archive_info": {"hashes": {"sha256": "0" * 64}}}
    one = {"metadata": {"name": "A_b.c", "version": "1.0"}, "download_info": archive}
    own = {"metadata": {"name": "garmentq", "version": "0"}, "download_info": {}}
    torch = {"metadata": {"name": "torch", "version": "2.1.0+cpu"}, "download_info": archive}
    made = supply.write_lock({"install": [one, own, torch]})
    assert "whl/cpu torch==2.1.0\n" in made and "+cpu" not in made
    assert made.splitlines()[-1] == f"a-b-c==1.0 --hash=sha256:{'0' * 64}"
