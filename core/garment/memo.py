"""Compute a property of an immutable object once, and keep it with the object."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

Value = TypeVar("Value")
Result = TypeVar("Result")


def memoise(function: Callable[[Value], Result]) -> Callable[[Value], Result]:
    """Make a function of one frozen dataclass compute its result only once for each object.

    What `functools.cached_property` does, for properties that live in a module above the object's own.
    """
    name = f"_{function.__name__}"

    @wraps(function)
    def find(value: Value) -> Result:
        known = vars(value)
        if name not in known:
            known[name] = function(value)
        result: Result = known[name]
        return result

    return find
