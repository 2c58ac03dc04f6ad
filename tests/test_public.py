"""The line between what users may import and what may change: `__all__` and its list in docs/reference/python.md."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
import re
import subprocess
import sys
from functools import cached_property
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]

LAYERS = ("core", "service", "workers", "cli")

PAGE = (ROOT / "docs" / "reference" / "python.md").read_text(encoding="utf-8").partition("## Public modules")[2]

PUBLIC = sorted(re.findall(r"`((?:core|service)\.[a-z_.]+)`", PAGE))


def list_functions(module: str) -> list[tuple[str, FunctionType]]:
    """Return the functions of a module's `__all__`, and the methods and properties of its classes."""
    loaded = importlib.import_module(f"garmentq.{module}")
    found: list[tuple[str, Any]] = []
    for name in loaded.__all__:
        value = getattr(loaded, name)
        if inspect.isclass(value):
            found += [(f"{name}.{own}", each) for own, each in vars(value).items() if not own.startswith("_")]
        else:
            found.append((name, value))
    bare = [(name, _unwrap(value)) for name, value in found]
    return [(name, value) for name, value in bare if isinstance(value, FunctionType)]


def _unwrap(value: Any) -> Any:
    if isinstance(value, property):
        return value.fget
    if isinstance(value, cached_property):
        return value.func
    return getattr(value, "__func__", value)


def test_modules_with_public_names_are_those_of_the_page():
    """Broken where a module becomes public without a word, or a public one is renamed."""
    declared = []
    for path in (path for layer in LAYERS for path in (ROOT / layer).rglob("*.py")):
        targets = [t for node in ast.parse(path.read_text()).body if isinstance(node, ast.Assign) for t in node.targets]
        if any(isinstance(target, ast.Name) and target.id == "__all__" for target in targets):
            declared.append(".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"))
    assert sorted(declared) == PUBLIC


@pytest.mark.parametrize("module", PUBLIC)
def test_public_names_are_there_and_documented(module):
    """Broken where `__all__` names what is gone, or a public class or function says nothing of itself."""
    loaded = importlib.import_module(f"garmentq.{module}")
    named = {name: getattr(loaded, name) for name in loaded.__all__}
    assert [name for name, value in named.items() if callable(value) and not value.__doc__] == []


@pytest.mark.parametrize("module", PUBLIC)
def test_public_functions_give_the_shapes_of_arrays(module):
    """Broken where an array goes in or out and its reader has to open the code to learn its shape."""
    arrays = re.compile(r"\b(ndarray|Tensor)\b")
    shaped = re.compile(r"\[(n\w|[^\[\]]*(count|\d))[^\[\]]*\]")
    lacking = [
        name
        for name, function in list_functions(module)
        if arrays.search(" ".join(map(str, function.__annotations__.values())))
        and not shaped.search(_all_text(function))
    ]
    assert lacking == []


def _all_text(function: FunctionType) -> str:
    return inspect.getdoc(function) or ""


def test_the_example_of_the_derivative_imports_what_exists():
    """Broken where the example names a module or a function that was moved."""
    place = ROOT / "examples" / "fit_by_gradient.py"
    specification = importlib.util.spec_from_file_location("fit_by_gradient", place)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["fit_by_gradient"] = module
    specification.loader.exec_module(module)
    assert callable(module.SkirtModel.at_rest)


@pytest.mark.nightly
def test_the_example_of_the_derivative_finds_what_was_changed():
    """Broken where torch's gradient through a drape on a body is another one than the drape's."""
    place = ROOT / "examples" / "fit_by_gradient.py"
    ran = subprocess.run([sys.executable, str(place)], check=True, capture_output=True, text=True)
    before, after = re.findall(r"([\d.]+) mm", ran.stdout)
    assert float(after) < 0.2 * float(before), ran.stdout
    found, true = (float(value) for value in re.findall(r"([\d.]+) times as stiff", ran.stdout))
    assert found == pytest.approx(true, rel=0.2), ran.stdout
