"""Find drawn numeric constants of `core` that may be 30 % off without a test or a golden scene noticing.

    python benchmarks/mutate.py --seed 7 [--count 30] [--minutes 40]

Each constant is multiplied by 0.7 and by 1.3 in a copy of the checkout. There the tests run that import its module,
and, where they pass, two golden scenes. Survivors are printed as a table; what was run lies in `out/mutate/SEED` and is
not run again.
"""

from __future__ import annotations

import argparse
import ast
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from changed_tree import ROOT, ChangedTree, try_all

FACTORS = (0.7, 1.3)

TEST_SECONDS, SCENE_SECONDS = 90.0, 300.0
"""Limits of the tests of one mutant and of its scenes, of CPU."""

SCENES = {
    "people": ("person_two", "foreign_skirt"), "scan": ("person_two", "foreign_skirt"),
    "body": ("person_two", "foreign_skirt"), "animate": ("animate", "edit"), "motion": ("animate", "edit"),
    "edit": ("edit", "export"), "wear": ("dress", "edit"), "pieces": ("export", "edit"), "export": ("export", "edit"),
    "formats": ("export", "edit"), "cloth": ("edit", "foreign_tank"), "fit": ("foreign_tank", "edit"),
}  # fmt: skip
"""Scenes that run most of a room or of a package in one; of the others `USUAL`."""

USUAL = ("foreign_skirt", "foreign_tank")

NOT_QUANTITIES = ("VERSION", "REVISION", "MAGIC", "PORT", "DIGITS", "COLOURS", "COLOR")
"""Words in names of constants that measure nothing."""


@dataclass(frozen=True)
class Constant:
    """A number in the value of a module's constant, or the default of a class's field.

    Attributes:
        path: Of its file, from the package's folder.
        name: Of the constant or the field.
        line: Where the number stands, from 1.
        column: Likewise, from 0.
        text: The number as written.
    """

    path: str
    name: str
    line: int
    column: int
    text: str

    def change(self, source: str, factor: float) -> str:
        """Return the file's text with the number times a factor; a whole number stays one, and is another one."""
        value = ast.literal_eval(self.text)
        other = value * factor
        if isinstance(value, int):
            other = round(other) if round(other) != value else value + (1 if factor > 1.0 else -1)
        lines = source.splitlines(keepends=True)
        own = lines[self.line - 1].encode()  # columns count bytes
        lines[self.line - 1] = (
            own[: self.column] + repr(other).encode() + own[self.column + len(self.text) :]
        ).decode()
        return "".join(lines)


@dataclass(frozen=True)
class Mutant:
    """Describe a constant that was changed, and what noticed.

    Attributes:
        constant: Which.
        factor: By what.
        caught_by: `tests`, `golden`, or empty for a survivor.
        told: What the run said last.
        seconds: Wall time.
    """

    constant: Constant
    factor: float
    caught_by: str
    told: str
    seconds: float


def list_constants(root: Path) -> list[Constant]:
    """Return the numbers of all constants and fields' defaults of `core`, but for 0, 1 and 2 as whole numbers."""
    found = []
    for path in sorted((root / "core").rglob("*.py")):
        source = path.read_text()
        for name, value in _list_values(ast.parse(source)):
            for node in ast.walk(value):
                is_number = isinstance(node, ast.Constant) and type(node.value) in (int, float)
                if is_number and not (type(node.value) is int and node.value <= 2) and node.value:
                    text = ast.get_source_segment(source, node) or ""
                    place = path.relative_to(root).as_posix()
                    found.append(Constant(place, name, node.lineno, node.col_offset, text))
    return found


def _list_values(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and not any("Enum" in ast.dump(base) for base in node.bases):
            for field in node.body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and field.value is not None:
                    yield field.target.id, field.value
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        names = [each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]
        value = getattr(node, "value", None)
        if value is not None and names and all(name.strip("_").isupper() for name in names):
            if not any(word in name for name in names for word in NOT_QUANTITIES):
                yield ", ".join(names), value


def list_tests(root: Path, path: str) -> list[str]:
    """Return the test files that import a module, itself or by what its package exports of it."""
    module = path.removesuffix(".py").replace("/", ".")
    package, _, own = module.rpartition(".")
    exported = set()
    init = root / package.replace(".", "/") / "__init__.py"
    for node in ast.walk(ast.parse(init.read_text())) if init.exists() else ():
        if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module == own:
            exported |= {each.asname or each.name for each in node.names}
    found = []
    for file in sorted((root / "tests").rglob("test_*.py")):
        if file.parent.name != "golden" and _imports(ast.parse(file.read_text()), package, module, exported):
            found.append(file.relative_to(root).as_posix())
    return found


def _imports(tree: ast.Module, package: str, module: str, exported: set[str]) -> bool:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            names = {each.name for each in node.names}
            if node.module == f"garmentq.{module}" or (node.module == f"garmentq.{package}" and names & exported):
                return True
            if node.module == f"garmentq.{package}" and module.rpartition(".")[2] in names:
                return True
    return False


def try_mutant(tree: ChangedTree, constant: Constant, factor: float) -> Mutant:
    """Change a constant in a copy and run what should notice."""
    begun = time.monotonic()
    text = constant.change((ROOT / constant.path).read_text(), factor)
    words = [name for name in constant.name.split(", ") if name.isupper()]
    with tree.changed(constant.path, text, words):
        tests = list_tests(tree.root, constant.path)
        ran = tree.test(tests, TEST_SECONDS) if tests else None
        caught = "tests" if ran is not None and ran.is_caught else ""
        if not caught:
            rooms = reversed(constant.path.split("/"))
            scenes = next((SCENES[room] for room in rooms if room in SCENES), USUAL)
            chosen = " or ".join(f"accepted and {name}" for name in scenes)
            ran = tree.test(["tests/golden", "-m", "nightly or not nightly", "-k", chosen], SCENE_SECONDS)
            caught = "golden" if ran.is_caught else ""
    return Mutant(constant, factor, caught, ran.told if ran else "", time.monotonic() - begun)


def run(seed: int, count: int, minutes: float, processes: int) -> list[Mutant]:
    """Return the mutants of a seed; those that were run before from their files."""
    constants = list_constants(ROOT)
    drawn = np.random.default_rng(seed).choice(len(constants), count, replace=False)
    asked = {f"{n}_{factor}": (constants[n], factor) for n in drawn for factor in FACTORS}

    def attempt(tree: ChangedTree, name: str) -> dict[str, Any]:
        mutant = try_mutant(tree, *asked[name])
        place = f"{mutant.constant.path} {mutant.constant.name} x {mutant.factor}"
        print(f"{place}: {mutant.caught_by or 'survives'}", file=sys.stderr)
        return asdict(mutant)

    found = try_all(ROOT / "out" / "mutate" / str(seed), list(asked), attempt, minutes, processes)
    return [Mutant(Constant(**told.pop("constant")), **told) for told in found.values()]


def main() -> None:
    """Print the survivors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=30, help="constants")
    parser.add_argument("--minutes", type=float, default=40.0, help="no mutant is begun later")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    mutants = run(given.seed, given.count, given.minutes, given.processes)
    by = {who: sum(mutant.caught_by == who for mutant in mutants) for who in ("tests", "golden", "")}
    print(
        f"{len(mutants)} of {2 * given.count} mutants: {by['tests']} caught by tests, {by['golden']} by golden scenes,"
    )
    print(f"{by['']} survive:\n\n| file | constant | number | factor | last line |\n|---|---|---|---|---|")
    for mutant in mutants:
        if not mutant.caught_by:
            one = mutant.constant
            print(f"| {one.path}:{one.line} | {one.name} | {one.text} | {mutant.factor} | {mutant.told} |")


if __name__ == "__main__":
    main()
