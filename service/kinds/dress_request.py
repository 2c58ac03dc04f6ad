"""What dressing another body is asked for; light, since the limited process that reads its file imports it."""

from __future__ import annotations

from dataclasses import dataclass

from ...core.body.spec import BuiltinWearer
from ...core.cloth.fabric import Fabric
from .request import FileRef, RequestBad

RESULT = "result"
"""Name of the input: the stored result whose garment is worn again."""

UNDER = "under"
"""Name of the other input, where there is one: the stored result whose garment it is worn over."""

BODY = "body.npz"
"""Holds what was read of the body's file, beside its folder."""


@dataclass(frozen=True)
class DressRequest:
    """Ask for a stored result on another body.

    Attributes:
        body: A body's file, a built-in body, or None: the wearer.
        pose: One of `body.POSES` that the body takes, or None: its own.
        fabric: Name of a shipped fabric, a fabric itself where it was imported, or None: the result's own cloth.
        units: A name of `UNITS`, of the body's file, or None to find it.
        up: Its axis that points up, or None to find it.
    """

    body: FileRef | BuiltinWearer | None = None
    pose: str | None = None
    fabric: str | Fabric | None = None
    units: str | None = None
    up: str | None = None

    def __post_init__(self) -> None:
        """Refuse names of what there is not.

        Raises:
            BodySpecBad: where body or pose is none.
            FabricUnknown: where the fabric is none.
            RequestBad: where unit or axis of a file are given without one.
        """
        from ...core.body.posing import check_wearer
        from ...core.cloth.fabrics import get_fabric

        check_wearer(self.body if isinstance(self.body, BuiltinWearer) else None, self.pose)
        if isinstance(self.fabric, str):
            get_fabric(self.fabric)
        if not isinstance(self.body, FileRef) and (self.units, self.up) != (None, None):
            raise RequestBad("units and up are those of a body's file; give the file, or leave them out.")
