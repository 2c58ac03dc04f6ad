"""The layers of the house: arrows point down only, and the rooms stay light at the door."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LAYERS = ("core", "service", "workers", "cli")
"""From the lowest to the highest."""
ROOMS = ("run", "geometry", "body", "scan", "garment", "cloth", "people", "judge", "recover", "reuse", "deliver")
"""The rooms of core, from the lowest to the highest; `docs/architecture.md` has them in the same order."""

INNER_ROOMS = {
    "body": ("", "motion", "models"),
    "scan": ("", "contours"),
    "garment": ("", "pieces"),
    "recover": ("settings", "drape", "grade", "deform", "recovery", "case", "proved_corner", "state", "fit", ""),
    "reuse": ("wear", "animate", "edit"),
    "deliver": ("ply", "texture", "formats", "export"),
}  # fmt: skip
"""Packages and modules in a room, from the lowest to the highest; `""` stands for all its other modules."""

Module = tuple[str, ...]


def find_modules() -> dict[Module, Path]:
    """Return the file of every module of all layers; a package stands for its `__init__`."""
    found = {}
    for layer in LAYERS:
        for path in (ROOT / layer).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[parts[:-1] if parts[-1] == "__init__" else parts] = path
    return found


def find_imports(path: Path) -> set[str]:
    """Return the layers that a module imports, wherever in it."""
    names = list(read_imports(path))
    found = {name[1] for name in names if len(name) > 1 and name[0] == "garmentq"}
    return found | {f"bare {name[0]}" for name in names if name and name[0] in LAYERS}


def read_imports(path: Path) -> Iterator[Module]:
    """Yield every imported name of a module with all its parts, those in functions and for types too."""
    package = ("garmentq", *path.relative_to(ROOT).parts[:-1])
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            base = (*base, *node.module.split(".")) if node.module else base
            yield from ((*base, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)


@cache
def import_graph() -> dict[Module, set[Module]]:
    """Return the modules that importing each module runs: what it names, and the packages around that but its own."""
    modules = find_modules()
    graph = {}
    for module, path in modules.items():
        named = {name[1:] for name in read_imports(path) if name[0] == "garmentq"}
        targets = {name if name in modules else name[:-1] for name in named}
        around = {name[:k] for name in targets for k in range(1, len(name)) if module[:k] != name[:k]}
        graph[module] = ((targets | around) & set(modules)) - {module}
    return graph


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
    assert ("core", "geometry") in import_graph()["core", "scan", "contours", "loop"]
    assert ("core", "geometry", "geometry") in import_graph()["core", "geometry", "surface"]
    assert ("core", "scan", "contours") in import_graph()["core", "garment", "templates"]


def find_rank(module: Module) -> tuple[int, int]:
    """Return the place of a module of core among the rooms, and in its room."""
    room = module[1]
    inner = INNER_ROOMS.get(room, ("",))
    name = module[2] if len(module) > 2 else ""
    own = module[1:2] == module[1:]  # the package itself imports whatever it hands out
    return ROOMS.index(room), len(inner) if own else inner.index(name if name in inner else "")


def test_rooms_know_only_lower_rooms():
    """Broken where a room of core imports one above it, or a new room has no place in the order."""
    graph = import_graph()
    assert {module[1] for module in graph if module[0] == "core" and len(module) > 1} == set(ROOMS)
    assert not [module for module in graph if module[0] == "core" and len(module) == 2 and module[1] not in ROOMS]
    wrong = {
        f"{'.'.join(module)} -> {'.'.join(other)}"
        for module, others in graph.items()
        for other in others
        if module[0] == other[0] == "core" and len(module) > 1 and len(other) > 1
        if (ROOMS.index(other[1]) > ROOMS.index(module[1])) or (len(other) > 2 and find_rank(other) > find_rank(module))
    }
    assert wrong == set()


def test_the_map_shows_every_room():
    """Broken where a room is missing from the map of the documentation, or stands there in another order."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `core/(\w+)` \|[^|]*\| ([^|]*)\|", text, re.MULTILINE)
    assert tuple(name for name, _ in rows) == ROOMS
    inner = {name: set(re.findall(r"\w+", cell)) for name, cell in rows}
    for room, names in INNER_ROOMS.items():
        packages = {name for name in names if (ROOT / "core" / room / name / "__init__.py").exists() and name}
        assert packages <= inner[room], room
    assert all((ROOT / "core" / room / name).is_dir() for room, names in inner.items() for name in names)


def test_no_circle_of_imports():
    """Broken where modules import each other in a circle, even within functions or for types only."""
    with pytest.raises(CycleError):
        TopologicalSorter({1: {2}, 2: {1}}).prepare()
    TopologicalSorter(import_graph()).prepare()


HEAVY = {"torch", "open3d", "igl", "numba"}


@pytest.mark.parametrize(
    ("module", "heavy"),
    [*((one, HEAVY) for one in ("cli.main", "service.jobs", "workers.embedded")),
     *((one, HEAVY) for one in ("core.recover.recovery", "core.geometry")),
     ("service.local", HEAVY | {"numpy", "scipy", "trimesh", "alembic", "httpx"}),
     ("service.api.app", HEAVY | {"scipy", "httpx", "trimesh"})],
)  # fmt: skip
def test_what_must_stay_light(module, heavy):
    """Broken where a command that only looks at the queue pays for torch or numpy, or the API for scipy."""
    code = f"import sys, garmentq.{module}; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_only_clouds_need_open3d():
    """Broken where the modules of a recovery, or of its files, load open3d, which takes a second and 100 MB."""
    code = (
        "import sys, garmentq.core.recover.pipeline, garmentq.core.deliver.export.result\n"
        "import garmentq.core.people.pipeline\n"
        "from garmentq.core.scan.load import load_scan\nfrom pathlib import Path\n"
        "load_scan(Path(sys.argv[1]))\n"
        "print('open3d' in sys.modules)"
    )
    line = [sys.executable, "-c", code, str(ROOT / "examples" / "data" / "garment.ply")]
    assert subprocess.run(line, capture_output=True, text=True, check=True).stdout.strip() == "False"


def test_the_workers_parent_has_no_torch():
    """Broken where the parent could run a torch operation before it forks: its children would hang."""
    code = "import sys, garmentq.workers.worker; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_files_are_of_a_size_to_read():
    """Broken where a module grows beyond what a reader takes in at once: 400 lines."""
    sizes = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for layer in LAYERS
        for path in (ROOT / layer).rglob("*.py")
    }
    assert {name: size for name, size in sizes.items() if size > 400} == {}


FACTORING = {
    "splu",
    "spilu",
    "spsolve",
    "spsolve_triangular",
    "factorized",
    "cholesky",
    "cholesky_banded",
    "cho_factor",
}
"""Names by which scipy and its like factor a matrix; those of `SPARSE` packages are meant."""

SPARSE = ("scipy.sparse", "sksparse", "pypardiso", "umfpack")
"""Packages that factor sparse matrices."""


def find_factoring(tree: ast.AST) -> set[str]:
    """Find what a module imports or calls to factor a sparse matrix, by whatever name."""
    found, aliases = set(), {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            aliases |= {name.asname or name.name.split(".")[0]: name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            aliases |= {name.asname or name.name: f"{node.module}.{name.name}" for name in node.names}
    for node in ast.walk(tree):
        if not isinstance(node, ast.Name | ast.Attribute):
            continue
        path = []
        while isinstance(node, ast.Attribute):
            path.append(node.attr)
            node = node.value
        if isinstance(node, ast.Name) and node.id in aliases:
            whole = ".".join([aliases[node.id], *reversed(path)])
            if whole.startswith(SPARSE) and whole.split(".")[-1] in FACTORING:
                found.add(whole)
    imported = {whole for whole in aliases.values() if whole.startswith(SPARSE) and whole.split(".")[-1] in FACTORING}
    return found | imported


def test_sparse_matrices_are_factored_in_one_place():
    """Broken where a room factors a sparse matrix by itself: with options, and checks, of its own."""
    modules = [path for layer in LAYERS for path in (ROOT / layer).rglob("*.py")]
    found = {
        str(path.relative_to(ROOT)): find_factoring(ast.parse(path.read_text(encoding="utf-8"))) for path in modules
    }
    assert {name: calls for name, calls in found.items() if calls and not name.startswith("core/geometry/")} == {}
    assert found["core/geometry/linear.py"]  # or the reader sees nothing


@pytest.mark.parametrize(
    "code",
    [
        "from scipy.sparse.linalg import splu as lu",
        "import scipy.sparse as sp\nsp.linalg.spsolve(1, 2)",
        "import scipy.sparse.linalg\nscipy.sparse.linalg.factorized(1)",
        "from scipy.sparse import linalg\nlinalg.splu(1)",
        "from sksparse.cholmod import cholesky",
    ],
)
def test_the_reader_of_factorisations_sees_them(code):
    """Broken where one of the ways to write it goes unseen."""
    assert find_factoring(ast.parse(code))
    assert not find_factoring(
        ast.parse("import numpy as np\nfrom scipy.linalg import cho_factor\nnp.linalg.cholesky(1)")
    )
