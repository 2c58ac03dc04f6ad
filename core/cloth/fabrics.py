"""The fabric library: named fabrics with the source of each number."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

from ..run.errors import NotFound
from .fabric import Fabric

__all__ = ["DEFAULT_FABRIC", "FabricUnknown", "get_fabric", "load_fabrics"]

PARAMETERS = ("density", "H00", "H01", "H11", "H22", "k", "thickness", "friction")
"""The numbers of each fabric, every one with its source."""


DEFAULT_FABRIC = "cotton_poplin"
"""Fabric of a recovery that names none: a plain cotton weave, mid-range in weight and stiffness."""


class FabricUnknown(NotFound):
    """No fabric of that name is in the library; `garmentq materials` lists them."""

    code = "fabric.unknown"


@cache
def load_fabrics() -> tuple[Fabric, ...]:
    """Return all fabrics of the library, by name. Every number's source says `measured: where`, `derived: how` or
    `assumed: plausible range`. Bending: eq. 3.4's k is twice the flexural rigidity B of a textile laboratory (see
    `bending.py`)."""
    rows = json.loads(Path(__file__).with_name("fabrics.json").read_text(encoding="utf-8"))
    return tuple(
        Fabric(
            name=row["name"],
            title=row["title"],
            sources=tuple((name, row["sources"][name]) for name in PARAMETERS),
            **{name: float(row[name]) for name in PARAMETERS},
        )
        for row in rows
    )


def get_fabric(name: str | Fabric | None = None) -> Fabric:
    """Return a shipped fabric by its name, a given `Fabric` itself, or for None `DEFAULT_FABRIC`.

    Raises:
        FabricUnknown: where there is none; the message lists the known names.
    """
    if isinstance(name, Fabric):
        return name
    name = DEFAULT_FABRIC if name is None else name
    for fabric in load_fabrics():
        if fabric.name == name:
            return fabric
    known = ", ".join(fabric.name for fabric in load_fabrics())
    raise FabricUnknown(f"no fabric '{name}' in the library; there are: {known}.")
