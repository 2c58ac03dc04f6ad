"""The wearer: a mesh with joints, bones, skinning weights and a signed distance."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .body import JOINTS, PARENTS, Body

if TYPE_CHECKING:
    from .distance import DistanceBad, DistanceGrid, sample_distance

_LAZY = {"DistanceBad": "distance", "DistanceGrid": "distance", "sample_distance": "distance"}
# Modules with compiled kernels or heavy libraries: imported on first use, so that the room itself stays light.

__all__ = ["JOINTS", "PARENTS", "Body", "DistanceBad", "DistanceGrid", "sample_distance"]


def __getattr__(name: str) -> Any:
    """Import a name's module when the name is first asked for."""
    if name in _LAZY:
        return getattr(importlib.import_module(f".{_LAZY[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
