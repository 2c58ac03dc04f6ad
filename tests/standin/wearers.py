"""Wearers that many tests share, each made once a process with its distance fields."""

from __future__ import annotations

from functools import cache

from garmentq.core.body.builtin import builtin_body
from garmentq.core.recover.drape.wearer import WearerGeometry

WOMAN = "builtin:female,height=1.70"
"""The body the shipped templates were drafted for."""


@cache
def find_wearer(spec: str = WOMAN) -> WearerGeometry:
    """Return a built-in body's geometry; frozen, so that tests can share it."""
    return WearerGeometry(builtin_body(spec))
