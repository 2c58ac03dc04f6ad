"""The rules of writing that a machine can hold: names of constants, verbs and words (docs/writing.md)."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

LAYERS = ("core", "service", "workers", "cli")


def list_modules(*folders: str) -> Iterator[Path]:
    """Yield the modules below some folders of the checkout."""
    for folder in folders:
        yield from sorted((ROOT / folder).rglob("*.py"))


def is_number(node: ast.AST | None) -> bool:
    """Check whether an expression is made of numbers alone: `0.02`, `-1`, `np.radians(5.0)`, `(0.1, 0.2)`."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.BinOp):
        return is_number(node.left) or is_number(node.right)
    if isinstance(node, ast.Tuple | ast.List):
        return bool(node.elts) and all(map(is_number, node.elts))
    if isinstance(node, ast.Call):
        return bool(node.args) and all(map(is_number, node.args))
    return False


def list_constants(path: Path) -> Iterator[tuple[str, int, str]]:
    """Yield the numeric constants of a module: name, line, and the docstring that follows, or nothing."""
    body = ast.parse(path.read_text(encoding="utf-8")).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        target = node.target if isinstance(node, ast.AnnAssign) else None
        targets = node.targets if isinstance(node, ast.Assign) else [target] if target else []
        value = getattr(node, "value", None)
        names = [
            one.id
            for each in targets
            for one in (each.elts if isinstance(each, ast.Tuple) else [each])
            if isinstance(one, ast.Name)
        ]
        value_after = after.value if isinstance(after, ast.Expr) else None
        is_text = isinstance(value_after, ast.Constant) and isinstance(value_after.value, str)
        docstring = " ".join(value_after.value.split()) if is_text else ""
        if is_number(value):
            yield from ((name, node.lineno, docstring) for name in names if name.strip("_").isupper())


@cache
def list_all() -> dict[tuple[str, str], tuple[int, str]]:
    """Return line and docstring of each numeric constant of all layers, by path and name."""
    return {
        (str(path.relative_to(ROOT)), name): (line, docstring)
        for path in list_modules(*LAYERS)
        for name, line, docstring in list_constants(path)
    }


REPLACED_SOON = {
    f"core/people/{name}.py"
    for name in (
        "bare_chest", "cloths", "coat", "colour", "colours", "depth", "evidence", "front", "looseness", "prior",
        "rules", "tone",
    )
}  # fmt: skip
"""Evidence and rules of the labelling, which a trained model replaces: they keep the names that they have."""

EXIT_CODES = "cli/exits.py"
"""Its constants are read as `exits.NAME`."""

UNIT = re.compile(r"\[(1|[^\]]*[A-Za-z][^\]]*)\]")
"""A unit in brackets: `[m]`, `[leg lengths]`, `[1]`; no shape or range, such as `[3, 3]` or `[0, 1]`."""

UNITLESS = re.compile(
    r"((largest|smallest|least|mean|approximate|accepted)( and (largest|smallest))? )?"
    r"(numbers?|shares?|ratios?|factors?|fractions?|multiple|quantiles?|relative|cosine|sine|probability|log-odds|"
    r"log-probability|index|indices|version|colours?|codes?|flags|permission bits|(exit|http) status(es)?|mask|matrix|"
    r"rotation)\b|weights?\b.* relative to\b|.*\bas a (share|fraction) of\b",
    re.IGNORECASE,
)
"""How the docstring of a number without unit begins; a weight says what it is relative to."""

SAME_IN_TWO_LAYERS = {"MAX_JOBS_PER_REQUEST", "MAX_ORDERS_PER_REQUEST", "MAX_WAIT_SECONDS", "GARBAGE_GRACE_HOURS"}
"""Bounds of the service that a command or a client has without importing it; tests compare both."""

PUBLISHED = {"Asked"}
"""Names of answers in the HTTP description, which generated clients have."""

UNGUESSABLE = {
    "tell", "tells", "told", "held", "asked", "crumbs", "ironing", "mourn", "believe", "believed", "foresee",
    "crumb", "remind", "weigh",
}  # fmt: skip
"""Words that no function or class of a public name begins with: they say nothing of what is computed."""


VAGUE = {
    "told", "asked", "held", "mine", "theirs", "given", "wanted", "crumbs", "bite", "bites", "freedom", "learnt",
    "ironed", "foresee", "believed", "mended", "gone", "like", "swallowed", "hopeless", "doomed",
    "spoken", "promised",
}  # fmt: skip
"""Words that are no noun of a quantity: a parameter, field or local of this name says nothing of what it is."""

WRITTEN_SCRIPT = "core/deliver/export/programs/clo.py"
"""A script that is written to results as it is."""


def test_numeric_constants_carry_a_noun() -> None:
    """Broken where a constant is called `ROUNDS` or `LEAST`: at the place of use nobody sees of what."""
    bare = [
        f"{path}:{line} {name}"
        for (path, name), (line, _) in list_all().items()
        if "_" not in name.strip("_") and path not in {*REPLACED_SOON, EXIT_CODES}
    ]
    assert bare == []


def test_no_two_numeric_constants_have_one_name() -> None:
    """Broken where two modules mean two things by one name, or keep the same number twice."""
    homes: dict[str, list[str]] = {}
    for path, name in list_all():
        if path not in {*REPLACED_SOON, EXIT_CODES}:
            homes.setdefault(name.strip("_"), []).append(path)
    assert {name: paths for name, paths in homes.items() if len(paths) > 1 and name not in SAME_IN_TWO_LAYERS} == {}


def test_numeric_constants_say_what_they_are() -> None:
    """Broken where a constant has no docstring with its unit and its reason; of several in a row the last has it."""
    lacking = [
        f"{path}:{line} {name}"
        for (path, name), (line, docstring) in list_all().items()
        if not docstring and not is_followed(path, line) and path not in {*REPLACED_SOON, EXIT_CODES}
    ]
    assert lacking == []


def is_followed(path: str, line: int) -> bool:
    """Check whether the constant on the next line has the docstring of both."""
    lines = {found: docstring for (where, _), (found, docstring) in list_all().items() if where == path}
    return line + 1 in lines and (bool(lines[line + 1]) or is_followed(path, line + 1))


def states_unit(text: str) -> bool:
    """Check whether a description of a number has a unit, or begins as that of a number without one."""
    return UNIT.search(text) is not None or UNITLESS.match(text) is not None


def test_numeric_constants_state_their_unit() -> None:
    """Broken where nobody can tell whether a constant is in metres, in edges or a share."""
    lacking = [
        f"{path}:{line} {name}: {docstring}"
        for (path, name), (line, docstring) in list_all().items()
        if docstring and not states_unit(docstring) and path not in {*REPLACED_SOON, EXIT_CODES}
    ]
    assert lacking == []


def list_settings(path: Path) -> Iterator[tuple[str, str, str]]:
    """Yield the numbers of a module's settings: class, name, and the entry in the class' `Attributes:`, or nothing."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef) and node.name.endswith("Settings"):
            attributes = (ast.get_docstring(node) or "").partition("Attributes:")[2]
            entries = re.findall(r"^    ([a-z_, ]+): ((?:.|\n {8})*)", attributes, re.MULTILINE)
            documented = {name: " ".join(text.split()) for names, text in entries for name in names.split(", ")}
            for field in node.body:
                if isinstance(field, ast.AnnAssign) and re.search(r"\b(int|float)\b", ast.unparse(field.annotation)):
                    name = ast.unparse(field.target)
                    yield node.name, name, documented.get(name, "")


def test_settings_state_their_unit() -> None:
    """Broken where a number of an estimator's settings has no entry in `Attributes:`, or none with a unit."""
    found = [(path.name, *each) for path in list_modules("core") for each in list_settings(path)]
    assert len(found) > 100
    assert [f"{path} {of}.{name}: {text}" for path, of, name, text in found if not states_unit(text)] == []


def test_units_are_recognised() -> None:
    """Broken where the test of units passes a length without unit, or a shape in place of one."""
    passing = ("Width of a band [m].", "Least share of faces.", "Stretch [1] above which", "Weight of x relative to y.")
    lacking = ("Width of a band.", "Rotations, shape [3, 3].", "Weight of a node.", "Range [0, 1] of depths.")
    assert all(map(states_unit, passing)) and not any(map(states_unit, lacking))


def list_public_names(path: Path) -> Iterator[str]:
    """Yield the functions and classes of a module that do not begin with an underscore."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node.name


@pytest.mark.parametrize("layer", LAYERS)
def test_names_begin_with_words_of_the_field(layer: str) -> None:
    """Broken where a function tells, holds or believes: verbs that no engineer looks for."""
    found = {
        f"{path.relative_to(ROOT)} {name}"
        for path in list_modules(layer)
        if str(path.relative_to(ROOT)) not in REPLACED_SOON
        for name in list_public_names(path)
        if name not in PUBLISHED
        if re.findall(r"[A-Z]?[a-z]+", name)[:1] and re.findall(r"[A-Z]?[a-z]+", name)[0].lower() in UNGUESSABLE
    }
    assert found == set()


def list_bound_names(path: Path) -> Iterator[tuple[str, int]]:
    """Yield the fields, parameters, methods and locals of a module, with their lines."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id, node.lineno
        elif isinstance(node, ast.arg):
            yield node.arg, node.lineno
        elif isinstance(node, ast.FunctionDef):
            yield node.name, node.lineno


@pytest.mark.parametrize("layer", LAYERS)
def test_fields_parameters_and_locals_say_what_they_are(layer: str) -> None:
    """Broken where a value is called `told`, `held` or `mine`: a reader cannot guess its kind."""
    found = {
        f"{path.relative_to(ROOT)}:{line} {name}"
        for path in list_modules(layer)
        if str(path.relative_to(ROOT)) not in {*REPLACED_SOON, WRITTEN_SCRIPT}
        for name, line in list_bound_names(path)
        if name.strip("_") in VAGUE
    }
    assert found == set()
    assert any(list_bound_names(path) for path in list_modules(layer))


def test_the_reader_of_constants_sees_them() -> None:
    """Broken where the tests above read nothing and so cannot fail."""
    found = Counter(path.split("/")[0] for path, _ in list_all())
    assert found["core"] > 500 and min(found[layer] for layer in LAYERS) > 3
    assert ("core/run/units.py", "MM_PER_M") in list_all()
