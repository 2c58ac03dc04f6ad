"""The names of a pattern's lines and points, and its panels that are cut as one piece, for the editor's script."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.run.errors import GarmentqError


def describe_names(content: bytes) -> dict[str, Any]:
    """Return the names of each panel's edges and points, and for panels that are cut as one piece their places in it:
    translation [m] and turn [rad]. Empty for a file that is not a pattern; the editor's script states why.

    Args:
        content: A pattern file.
    """
    from ...core.garment.garmentcode import read_pattern
    from ...core.garment.pieces.edge_names import name_edges
    from ...core.garment.pieces.joining import join_halves, turn_group

    try:
        pattern = read_pattern(content)
        names = name_edges(pattern)
        groups = [turn_group(group) for group in join_halves(pattern) if len(group.places) > 1]
    except GarmentqError:
        return {}
    return {
        "panels": {
            name: {"lines": found.lines, "sides": found.sides, "points": found.points} for name, found in names.items()
        },
        "pieces": [
            [
                {
                    "panel": place.panel,
                    "x": float(place.translation[0]),
                    "y": float(place.translation[1]),
                    "turn": float(np.arctan2(place.rotation[1, 0], place.rotation[0, 0])),
                }
                for place in group.places
            ]
            for group in groups
        ],
    }
