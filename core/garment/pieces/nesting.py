"""Nest pieces on cloth by their outlines, where the extra `nest` is installed."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np

from ...geometry.rigid import plane_rotation
from .layout import CLOTH_GAP, CLOTH_WIDTH, Copy, Lay, lay_on_cloth, list_copies
from .piece import Piece

NESTING_EXPLORATION_TIME, NESTING_COMPRESSION_TIME = 2, 1
"""Wall times of the search's exploration and of its compression [s]; three times as long shortened none of four shipped
garments."""

GRAIN_TURNS_DEG = (0.0, 180.0)
"""Turns that keep the grainline [degrees]; cloth with a nap allows only the first."""


def can_nest() -> bool:
    """Return whether the extra `nest` is installed."""
    return find_spec("spyrrow") is not None


def nest_on_cloth(pieces: tuple[Piece, ...], width: float = CLOTH_WIDTH) -> Lay:
    """Return the shorter lay of pieces: nested by their outlines, or without the extra in boxes on shelves. The search
    (Gardeyn, Vanden Berghe, Wauters, "An open-source heuristic to reboot 2D nesting research", 2025; the library
    `spyrrow`) ends by wall time: on a slower machine a lay may be longer.

    Args:
        pieces: The pieces.
        width: Usable width of the cloth [m].
    """
    boxes = lay_on_cloth(pieces, width)
    if not can_nest() or not boxes.copies:
        return boxes
    import spyrrow

    # The library's strip grows along x, our cloth along y.
    copies = list_copies(pieces)
    turned = [np.stack([copy.outline[:, 1], -copy.outline[:, 0]], axis=1) for copy in copies]
    items = [
        spyrrow.Item(str(n), [(x, y) for x, y in one.tolist()], 1, GRAIN_TURNS_DEG) for n, one in enumerate(turned)
    ]
    settings = spyrrow.StripPackingConfig(
        total_computation_time=None,
        exploration_time=NESTING_EXPLORATION_TIME,
        compression_time=NESTING_COMPRESSION_TIME,
        min_items_separation=CLOTH_GAP,
        num_workers=1,
        seed=0,
    )
    solution = spyrrow.StripPackingInstance("pieces", width, items).solve(settings)
    laid = []
    for item in solution.placed_items:
        angle = np.radians(item.rotation)
        rotation = plane_rotation(angle)
        placed = turned[int(item.id)] @ rotation.T + item.translation
        laid.append(Copy(copies[int(item.id)].name, np.stack([-placed[:, 1], placed[:, 0]], axis=1)))
    low = np.min([copy.outline.min(axis=0) for copy in laid], axis=0)
    nested = Lay.of(tuple(Copy(copy.name, copy.outline - low) for copy in laid), width)
    return nested if nested.length < boxes.length else boxes
