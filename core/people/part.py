"""Define the parts of a dressed person."""

from __future__ import annotations

from enum import IntEnum


class Part(IntEnum):
    """Name a part; the value is its number in a labels file."""

    SKIN = 0
    HAIR = 1
    SHOES = 2
    UPPER = 10
    LOWER = 11
    ONE_PIECE = 12
    OUTER = 13
    OTHER = 20

    @property
    def word(self) -> str:
        """Return its name in texts, options and folders: `one-piece`."""
        return self.name.lower().replace("_", "-")


PARTS = tuple(Part)
"""The columns of a posterior, in their order."""

GARMENTS = (Part.UPPER, Part.LOWER, Part.ONE_PIECE, Part.OUTER)
"""Parts that are recovered, each by a job of its own."""

CLOTH = (*GARMENTS, Part.OTHER)
"""Parts that hide the body; its skin is somewhere below."""
