"""The wearer: a mesh with joints, bones, skinning weights and a signed distance."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .body import JOINTS, PARENTS, Body
from .spec import BUILTIN, is_builtin

if TYPE_CHECKING:
    from .builtin import BodyMissing, BodySpecBad, builtin_body, describe_bodies, parse_spec
    from .distance import DistanceBad, DistanceGrid, sample_distance
    from .model import BodyModel
    from .outside import BodySurface
    from .registration import NotHuman, register_body
    from .skinning import rest_body, skin, unskin, weights_at
    from .smpl import SmplBad, is_smpl, load_smpl
    from .solid import Solid
    from .surface import signed_distance

_LAZY = {
    "BodyMissing": "builtin",
    "BodyModel": "model",
    "BodySpecBad": "builtin",
    "BodySurface": "outside",
    "DistanceBad": "distance",
    "DistanceGrid": "distance",
    "NotHuman": "registration",
    "SmplBad": "smpl",
    "Solid": "solid",
    "builtin_body": "builtin",
    "describe_bodies": "builtin",
    "is_smpl": "smpl",
    "load_smpl": "smpl",
    "parse_spec": "builtin",
    "register_body": "registration",
    "rest_body": "skinning",
    "sample_distance": "distance",
    "signed_distance": "surface",
    "skin": "skinning",
    "unskin": "skinning",
    "weights_at": "skinning",
}
# Modules with compiled kernels or heavy libraries: imported on first use, so that the room itself stays light.

__all__ = [
    "BUILTIN",
    "JOINTS",
    "PARENTS",
    "Body",
    "BodyMissing",
    "BodyModel",
    "BodySpecBad",
    "BodySurface",
    "DistanceBad",
    "DistanceGrid",
    "NotHuman",
    "SmplBad",
    "Solid",
    "builtin_body",
    "describe_bodies",
    "is_builtin",
    "is_smpl",
    "load_smpl",
    "parse_spec",
    "register_body",
    "rest_body",
    "sample_distance",
    "signed_distance",
    "skin",
    "unskin",
    "weights_at",
]


def __getattr__(name: str) -> Any:
    """Import a name's module when the name is first asked for."""
    if name in _LAZY:
        return getattr(importlib.import_module(f".{_LAZY[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
