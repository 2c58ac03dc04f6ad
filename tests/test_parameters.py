"""How much a function may ask of its caller."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
LAYERS = ("core", "service", "workers", "cli")

MOST = 8
"""Parameters of one function, `self` and `cls` left out; what travels together is one object."""

EXCEPTIONS = {
    "cli/submit.py:command": "a click command: a parameter an option, from which it builds one object",
    "cli/animate.py:command": "a click command, as above",
}
"""Functions that may have more, each with the reason."""


def count_parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Count a function's parameters; `*args` and `**options` count as one each."""
    given = function.args
    named = [*given.posonlyargs, *given.args, *given.kwonlyargs]
    if named and named[0].arg in ("self", "cls"):
        named = named[1:]
    return len(named) + (given.vararg is not None) + (given.kwarg is not None)


def find_functions(path: Path) -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """Yield every function of a module with its name, methods and inner functions too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name, node


def test_functions_take_few_parameters() -> None:
    """Breaks where a function asks for more than eight things one by one, or an exception is no longer needed."""
    wide = {
        f"{path.relative_to(ROOT).as_posix()}:{name}": count_parameters(function)
        for layer in LAYERS
        for path in (ROOT / layer).rglob("*.py")
        for name, function in find_functions(path)
        if count_parameters(function) > MOST
    }
    assert {name: count for name, count in wide.items() if name not in EXCEPTIONS} == {}
    assert set(EXCEPTIONS) <= set(wide), "an exception that nothing needs"


def test_the_count_sees_every_kind_of_parameter() -> None:
    """Breaks where the rule above could be met by hiding parameters."""
    source = "class A:\n async def f(self, a, /, b, *c, d=1, **e): ...\n"
    [(name, function)] = [
        (node.name, node) for node in ast.walk(ast.parse(source)) if isinstance(node, ast.AsyncFunctionDef)
    ]
    assert (name, count_parameters(function)) == ("f", 5)
