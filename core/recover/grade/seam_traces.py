"""Find the seams that a scan shows by the colours or the stripes of its cloth."""

from __future__ import annotations

from collections import Counter
from enum import StrEnum

import numpy as np

from ...garment.garment import Garment
from ...garment.pieces.pattern_lines import PatternLine
from ...geometry.surface import TriangleSurface
from ...scan.contours.target import Target
from .colour_seams import find_colour_trace
from .seam_strips import SEARCH_STEP, SeamStrip, SeamTrace, sample_strips
from .stripe_seams import ROWS_PER_PLACE, find_stripe_trace


class TraceKind(StrEnum):
    """Describe what of the cloth shows a seam, the clearest first."""

    COLOUR = "colour"
    STRIPES = "stripes"


def find_seam_traces(garment: Garment, target: Target) -> dict[PatternLine, tuple[TraceKind, SeamTrace]]:
    """Find where a scan shows seams of a drafted garment, each by the clearest of its traces.

    Args:
        garment: The garment, its nodes on the scan [m].
        target: The scan's surface; one without colours shows none.
    """
    colours = target.colours
    if colours is None or not len(target.faces):
        return {}
    faces = target.faces[(target.faces < len(colours)).all(axis=1)]
    surface = TriangleSurface(target.vertices, faces)
    edge = np.linalg.norm(surface.vertices[faces[:, 0]] - surface.vertices[faces[:, 1]], axis=1).mean()
    blur = int(np.ceil(edge / SEARCH_STEP))
    strips, close = list(sample_strips(garment, surface)), sample_strips(garment, surface, ROWS_PER_PLACE)
    traces = {
        TraceKind.COLOUR: [find_colour_trace(one, one.interpolate(colours, faces), blur) for one in strips],
        TraceKind.STRIPES: _keep_pairs(
            strips,
            [
                find_stripe_trace(one, fine.interpolate(colours, faces), blur)
                for one, fine in zip(strips, close, strict=True)
            ],
        ),
    }
    found: dict[PatternLine, tuple[TraceKind, SeamTrace]] = {}
    for kind in TraceKind:
        for strip, trace in zip(strips, traces[kind], strict=True):
            if trace is not None:
                found.setdefault(strip.line, (kind, trace))
    return found


def _keep_pairs(strips: list[SeamStrip], traces: list[SeamTrace | None]) -> list[SeamTrace | None]:
    """Return traces that both of a left and a right seam have, which are cut and sewn alike: one alone may be a
    print."""
    counts = Counter(strip.line.name for strip, trace in zip(strips, traces, strict=True) if trace is not None)
    sides = Counter(strip.line.name for strip in strips)
    return [
        trace if counts[strip.line.name] == sides[strip.line.name] else None
        for strip, trace in zip(strips, traces, strict=True)
    ]
