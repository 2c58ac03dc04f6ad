"""The request of dressing a body; the module is light, because the limited process that reads its file imports it."""

from __future__ import annotations

from dataclasses import dataclass

from ...core.body.spec import BuiltinWearer
from ...core.cloth.fabric import Fabric
from .request import BuiltinText, FileRef, RequestBad

RESULT = "result"
"""Name of the input: the stored result whose garment is worn again."""

UNDER = "under"
"""Name of the optional input: the stored result whose garment is worn below."""

BODY = "body.npz"
"""File with the arrays of the body, beside its folder."""


@dataclass(frozen=True)
class DressRequest:
    """Describe a stored result that is worn by another body.

    Attributes:
        body: A body's file, a built-in body, or None: the wearer.
        pose: One of `body.POSES`, or None: the body's own.
        fabric: Name of a shipped fabric, an imported fabric itself, or None: the result's own.
        units: A name of `UNITS`, of the body's file, or None to detect it.
        up: Its axis that points up, or None to detect it.
    """

    body: FileRef | BuiltinText | None = None
    pose: str | None = None
    fabric: str | Fabric | None = None
    units: str | None = None
    up: str | None = None

    def __post_init__(self) -> None:
        """Refuse unknown names.

        Raises:
            BodySpecBad: if body or pose is unknown.
            FabricUnknown: if the fabric is unknown.
            RequestBad: if unit or axis are given without a file.
        """
        from ...core.body.posing import check_wearer
        from ...core.cloth.fabrics import get_fabric

        check_wearer(self.body if isinstance(self.body, BuiltinWearer) else None, self.pose)
        if isinstance(self.fabric, str):
            get_fabric(self.fabric)
        if not isinstance(self.body, FileRef) and (self.units, self.up) != (None, None):
            raise RequestBad("units and up are those of a body's file; give the file, or leave them out.")
