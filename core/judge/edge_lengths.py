"""Compare the lengths of a garment's open edges on the scan with those of the pattern as it hangs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..garment.garment import Garment
from ..scan.contours.loop import smoothed_length
from ..scan.contours.target import Target
from .line_intervals import Evidence, LineInterval


def find_length_differences(
    garment: Garment, nodes: np.ndarray, target: Target, intervals: Sequence[LineInterval]
) -> tuple[str, ...]:
    """Return a sentence for each edge whose length on the scan is not that of the pattern as it hangs.

    The drape has the stretch that cloth and weight explain; what remains beyond the interval of the edge's length the
    pattern has wrong, or the edge on the scan is not that of the cloth: curled, torn, or drawn in.

    Args:
        garment: The recovered garment, its contours named.
        nodes: Of the drape of its pattern [m], shape [node_count, 3].
        target: The scan's surface, its contours named.
        intervals: Of the pattern's lines.
    """
    shown = {contour.name: contour for contour in target.contours if contour.trusted and contour.is_closed}
    hanging = {contour.name: contour for contour in garment.contours if contour.is_closed}
    found = []
    for one in intervals:
        name = one.line.find_contour(garment.pattern)
        if one.evidence is not Evidence.EDGE or name not in shown or name not in hanging or one.length_margin is None:
            continue
        scanned, drape = (
            smoothed_length(points[contour.vertices])
            for points, contour in ((target.vertices, shown[name]), (nodes, hanging[name]))
        )
        if abs(np.log(scanned / drape)) > np.log1p(one.length_margin / one.length):
            side = f" {one.line.side}" if one.line.side else ""
            found.append(
                f"the {one.line.name}{side} is {100.0 * scanned:.1f} cm round on the scan and {100.0 * drape:.1f} cm "
                f"as the pattern hangs: its stretch and its interval of {100.0 * one.length_margin:.1f} cm do not "
                "explain that."
            )
    return tuple(found)
