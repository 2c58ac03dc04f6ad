"""An environment as the Dockerfile makes it holds nothing that may not be passed on, and all that is used."""

from __future__ import annotations

import ast
import json
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import distribution, packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]

MARKS = (b"tetgenio", b"CGAL::", b"triangledeinit")
"""What a library that holds TetGen, CGAL or Triangle has among its names."""

USES = """
import igl, numpy as np, trimesh, sys
from garmentq.core.body.solid import Solid
from garmentq.cli.bench import raw_states
import garmentq.training.body_assets
ball = trimesh.creation.icosphere(subdivisions=4)
points, faces = np.array(ball.vertices), np.array(ball.faces)
assert list(Solid(points, faces).contains(np.array([[0.0, 0, 0], [2.0, 0, 0]]))) == [True, False]
assert len(raw_states._collapse(points, faces, 500)[1]) == 1000
squared, _, _ = igl.point_mesh_squared_distance(np.array([[2.0, 0, 0]]), points, faces)
assert abs(squared - 1.0) < 1e-3
print(igl.__file__)
"""
"""What the three modules that use libigl do with it."""


@pytest.fixture
def packages(tmp_path):
    """Return a folder with libigl as pip installs the wheel of the lock."""
    found = distribution("libigl")
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    assert f"\nlibigl=={found.version} " in lock
    for file in found.files:
        if "__pycache__" not in str(file):
            place = tmp_path / "packages" / str(file)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(found.locate_file(file), place)
    return tmp_path / "packages"


def prune(packages: Path) -> subprocess.CompletedProcess[str]:
    """Run the script that the Dockerfile runs."""
    command = [sys.executable, str(ROOT / "deploy" / "prune.py"), str(packages)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def find_marked(packages: Path) -> list[str]:
    """Return the compiled modules that hold one of the libraries."""
    return sorted(
        path.relative_to(packages).as_posix()
        for path in packages.rglob("*.so*")
        if any(mark in path.read_bytes() for mark in MARKS)
    )


def test_the_image_removes_what_may_not_be_passed_on(packages):
    """Broken where a module with TetGen, CGAL or Triangle stays, one that is used goes, or the image skips the step."""
    assert len(find_marked(packages)) == 3
    done = prune(packages)
    assert done.returncode == 0 and re.fullmatch(r"removed \d+ files\n", done.stdout), done
    assert find_marked(packages) == [] and not list(packages.rglob("*copyleft*")) + list(packages.rglob("*triangle*"))
    [record] = packages.glob("libigl-*.dist-info/RECORD")
    listed = [line.split(",")[0] for line in record.read_text(encoding="utf-8").splitlines()]
    assert all((packages / name).exists() for name in listed if "__pycache__" not in name)
    work = f"import sys; sys.path.insert(0, {str(packages)!r})\n{USES}"
    used = subprocess.run([sys.executable, "-c", work], capture_output=True, text=True, check=False)
    assert used.returncode == 0 and used.stdout.strip() == str(packages / "igl" / "__init__.py"), used.stderr
    docker = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    assert re.search(r"^RUN pip install --require-hashes .* && python deploy/prune\.py$", docker, re.MULTILINE)


@pytest.mark.parametrize("change", ["gone", "moved", "new"])
def test_another_wheel_is_looked_at_first(packages, change):
    """Broken where a release of libigl with other modules is passed on without a look."""
    if change == "gone":
        shutil.rmtree(packages / "igl" / "triangle")
    elif change == "moved":
        shutil.move(packages / "igl" / "copyleft" / "tetgen", packages / "igl" / "tetgen")
    else:
        (packages / "igl" / "pyigl_other.abi3.so").write_bytes(b"")
    done = prune(packages)
    assert done.returncode != 0 and "look at" in done.stderr


def test_the_list_of_packages_says_what_was_removed(tmp_path):
    """Broken where an auditor reads of a whole libigl."""
    command = [sys.executable, str(ROOT / "deploy" / "supply.py"), "sbom", str(ROOT / "requirements.lock")]
    listed = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    told = {one["name"]: [word["value"] for word in one.get("properties", ())] for one in listed["components"]}
    assert {name: words for name, words in told.items() if words} == {"libigl": ["igl/copyleft", "igl/triangle"]}


UNSEEN = {
    "open3d": "the same package for other systems",
    "psycopg": "SQLAlchemy imports it by the database's address",
}
"""Packages that are required and that no import of ours names."""


def test_every_required_package_is_imported():
    """Broken where production gets a package that nothing uses."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    lines = [*project["dependencies"], *(line for name in ("postgres", "s3", "usd", "nest") for line in extras[name])]
    modules: dict[str, set[str]] = {}
    for module, names in packages_distributions().items():
        for name in names:
            modules.setdefault(re.sub(r"[-_.]+", "-", name).lower(), set()).add(module)
    imported = set()
    for room in ("core", "service", "workers", "cli", "migrations"):
        for path in (ROOT / room).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    imported |= {alias.name.split(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and not node.level and node.module:
                    imported.add(node.module.split(".")[0])
    needed = {re.sub(r"[-_.]+", "-", Requirement(line).name).lower() for line in lines}
    assert {name for name in needed if not modules.get(name, set()) & imported} == set(UNSEEN)
