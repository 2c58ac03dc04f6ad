"""The motions that come with garmentq, under CC0."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parent / "assets"

SHIPPED_MOTIONS = ("walk", "jumping-jack")
"""Names of the motions: a walk on the spot, half a second a step; a jumping jack, one a second."""


def find_shipped_motion(name: str) -> Path | None:
    """Return the file of a shipped motion, or None if no motion has that name."""
    return FOLDER / f"{name}.json" if name in SHIPPED_MOTIONS else None
