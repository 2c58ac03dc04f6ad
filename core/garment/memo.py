"""Compute a property of an immutable object once, and cache it in the object."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

Value = TypeVar("Value")
Result = TypeVar("Result")


def memoise(function: Callable[[Value], Result]) -> Callable[[Value], Result]:
    """Return a function of one frozen dataclass that computes its result once per object, as
    `functools.cached_property` does for a property in the object's own module."""
    name = f"_{function.__name__}"

    @wraps(function)
    def find(value: Value) -> Result:
        known = vars(value)
        if name not in known:
            known[name] = function(value)
        result: Result = known[name]
        return result

    return find
