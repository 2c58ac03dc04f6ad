"""The layers of the house: arrows point down only, and the rooms stay light at the door."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LAYERS = ("core", "service", "workers", "cli")
"""From the lowest to the highest."""


def find_imports(path: Path) -> set[str]:
    """Give the layers that a module imports, wherever in it."""
    package = ("garmentq", *path.relative_to(ROOT).parts[:-1])
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            parts = (*base, *(node.module or "").split(".")) if node.module else base
            names = [parts] if len(parts) > 1 else [(*parts, alias.name) for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [tuple(alias.name.split(".")) for alias in node.names]
        else:
            continue
        found |= {name[1] for name in names if len(name) > 1 and name[0] == "garmentq"}
        found |= {f"bare {name[0]}" for name in names if name and name[0] in LAYERS}
    return found


@pytest.mark.parametrize("layer", LAYERS)
def test_arrows_point_down(layer):
    """Broken where a lower layer knows a higher one, or a room is imported by its bare name (and so loaded twice)."""
    allowed = {*LAYERS[: LAYERS.index(layer) + 1], "__version__"}
    allowed |= {"migrations"} if layer == "service" else set()  # the service runs them; they import its models back
    modules = list((ROOT / layer).rglob("*.py"))
    assert modules
    wrong = {str(path.relative_to(ROOT)): find_imports(path) - allowed for path in modules}
    assert {name: layers for name, layers in wrong.items() if layers} == {}


def test_the_reader_of_imports_sees_them():
    """Broken where the test above reads nothing and so cannot fail."""
    assert {"service", "core"} <= find_imports(ROOT / "workers" / "recovery.py")
    assert "workers" in find_imports(ROOT / "cli" / "run.py")
    assert "migrations" in find_imports(ROOT / "service" / "database.py")


@pytest.mark.parametrize("module", ["cli.main", "service.jobs", "workers.embedded", "core.recovery"])
def test_what_must_stay_light(module):
    """Broken where a command that only looks at the queue pays for torch, or the worker's parent loads it."""
    code = f"import sys, garmentq.{module}; print(sorted({{'torch', 'open3d', 'igl', 'numba'}} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_workers_parent_has_no_torch():
    """Broken where the parent could run a torch operation before it forks: its children would hang."""
    code = "import sys, garmentq.workers.worker; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_files_are_of_a_size_to_read():
    """Broken where a module grows beyond what a reader takes in at once (400 lines, a tenth of grace)."""
    sizes = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for layer in LAYERS
        for path in (ROOT / layer).rglob("*.py")
    }
    assert {name: size for name, size in sizes.items() if size > 440} == {}
