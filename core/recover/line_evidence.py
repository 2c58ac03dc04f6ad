"""Find what decides where each line of a recovered pattern is."""

from __future__ import annotations

import numpy as np

from ..body.body import Body
from ..garment.garment import Garment
from ..garment.pieces.pattern_lines import PatternLine, list_lines
from ..judge.line_intervals import Evidence
from ..judge.seen import find_seen_nodes
from ..scan.contours.target import Target
from .grade.seam_traces import find_seam_traces
from .grade.seen_seams import find_seen_seams

SEEN_SEAM_DISTANCE = 0.01
"""Distance from where the cloth shows a seam within which it lies there [m]: a seam's allowance."""

MIN_SEEN_SHARE = 0.5
"""Share of a line's nodes from which what is true of them is true of it [1]."""


def find_line_evidence(
    garment: Garment, target: Target, body: Body, seen: np.ndarray
) -> tuple[tuple[PatternLine, Evidence], ...]:
    """Return the lines of a garment's pattern, and what decides where each is.

    Args:
        garment: The recovered garment, its nodes on the scan [m].
        target: The scan's surface, its contours named.
        body: The wearer.
        seen: Whether the scan shows each face, bool, shape [face_count].
    """
    shown = find_seen_nodes(garment, seen)
    by_curvature = np.zeros(len(garment.nodes), dtype=bool)
    for seam in find_seen_seams(garment, target, body):
        by_curvature[seam.nodes[np.abs(seam.distance(garment.nodes)) < SEEN_SEAM_DISTANCE]] = True
    traces = find_seam_traces(garment, target)
    ends = {contour.name: contour for contour in target.contours}
    found = []
    for line in list_lines(garment.pattern):
        nodes = line.find_nodes(garment)
        evidence = Evidence.PROPORTION
        if line.is_open:
            end = ends.get(line.find_contour(garment.pattern))
            evidence = Evidence.EDGE if end is not None and end.trusted and not end.hidden else Evidence.HIDDEN
        elif shown[nodes].mean() < MIN_SEEN_SHARE:
            evidence = Evidence.HIDDEN
        elif line in traces and traces[line][1].is_at(garment.nodes, SEEN_SEAM_DISTANCE):
            evidence = Evidence(str(traces[line][0]))
        elif by_curvature[nodes].mean() > MIN_SEEN_SHARE:
            evidence = Evidence.CURVATURE
        found.append((line, evidence))
    return tuple(found)
