"""Apply the parts that the user names at single places."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.connectivity import find_components
from ..scan.raw import RawScan
from ..scan.upright import turn_upright
from .diffusion import Links
from .hints import HintBad, Mark
from .part import GARMENTS, PARTS, Part
from .points import PersonPoints

MAX_MARK_DISTANCE = 0.1
"""Largest distance between a mark and the scan [m]: the accuracy of a place that is read off a picture."""

MARK_SKIN_RADIUS = 0.15
"""Radius around a mark within which skin is relabelled [m]: all skin is connected, and a mark cannot mean all of it."""


def list_marked_garments(marks: Sequence[Mark]) -> tuple[Part, ...]:
    """Return the garments that marks name, in the order of `GARMENTS`."""
    named = {mark.part for mark in marks}
    return tuple(part for part in GARMENTS if part in named)


def apply_marks(
    column: np.ndarray, marks: Sequence[Mark], raw: RawScan, points: PersonPoints, links: Links
) -> np.ndarray:
    """Return the columns with the piece at each mark changed to the part that the mark names.

    A piece is a connected set of samples of one part; of skin only what is within `MARK_SKIN_RADIUS` of the mark.

    Args:
        column: Of each sample's part, shape [n].
        marks: In the file's own coordinates.
        raw: The scan, which has unit and axis of the file.
        points: The samples.
        links: Neighbours.

    Raises:
        HintBad: where a mark is far from the scan.
    """
    column = column.copy()
    tree = cKDTree(points.positions)
    for mark in marks:
        place = turn_upright(mark.place[None], raw.up_axis)[0] * raw.scale
        distance, nearest = tree.query(place)
        if distance > MAX_MARK_DISTANCE:
            raise HintBad(
                f"The mark {mark.part.word} lies {distance:.2f} m from the scan; give it in the file's coordinates."
            )
        same = links.pairs[column[links.pairs[:, 0]] == column[links.pairs[:, 1]]]
        _, piece = find_components(links.count, same[:, 0], same[:, 1])
        chosen = piece == piece[nearest]
        if PARTS[column[nearest]] is Part.SKIN:
            chosen &= np.linalg.norm(points.positions - place, axis=1) < MARK_SKIN_RADIUS
        column[chosen] = PARTS.index(mark.part)
    return column
