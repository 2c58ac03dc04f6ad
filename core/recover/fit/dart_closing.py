"""Close darts of a fitted garment, in its pattern and base pattern, and move its nodes."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ...garment.editing.darts import Dart, close_dart
from ...garment.garment import Garment
from ...garment.pattern import EdgeRef, Pattern
from ...garment.seams import equalise_seams
from ...garment.symmetry import find_symmetry
from .dart_cutting import CutGarment, OpenPanel, relax_panels
from .dart_search import relax_panel


def required_dart_width(garment: Garment, strain: np.ndarray, dart: Dart) -> float:
    """Return the width of a dart's mouth at the least strain [m].

    Args:
        garment: The flat panels, fitted to the cloth on the target.
        strain: Wanted strain of each face, shape [face_count, 2, 2].
        dart: A dart of the garment's pattern.
    """
    index = [panel.name for panel in garment.pattern.panels].index(dart.panel)
    count = len(garment.pattern.panels[index].points)
    panel = relax_panel(garment, strain, index)
    first = int(np.flatnonzero(garment.panel_of_uv == index)[0])
    ends = [garment.edge_uv[EdgeRef(dart.panel, (dart.first + k) % count)][0] - first for k in (0, 2)]
    apart = np.diff(panel.uv[ends] + panel.motion[ends], axis=0)[0]
    sides = np.diff(panel.uv[ends], axis=0)[0]
    # sides that cross need no dart at all
    return float(np.linalg.norm(apart)) if float(apart @ sides) > 0.0 else 0.0


def close_darts(garment: Garment, strain: np.ndarray, base: Pattern, darts: Collection[Dart]) -> CutGarment:
    """Close darts of a fitted garment and of its base pattern.

    The control point at each mouth stays; in the base pattern it moves to the line between its neighbours.

    Args:
        garment: The flat panels, fitted to the cloth on the target.
        strain: Wanted strain of each face, shape [face_count, 2, 2].
        base: The base pattern.
        darts: Darts of both patterns.
    """
    names = {dart.panel for dart in darts}
    pattern, template = relax_panels(garment, strain, base, names)
    for dart in sorted(darts, key=lambda dart: (dart.panel, dart.first), reverse=True):
        pattern, template = close_dart(pattern, dart), _straighten_mouth(close_dart(template, dart), dart)
    opened = {}
    for index, panel in enumerate(garment.pattern.panels):
        if panel.name in names:
            flat = relax_panel(garment, strain, index)
            motion = flat.motion
            opened[index] = OpenPanel(flat, (), 0.0, motion, flat.uv + motion, flat.faces, np.arange(len(flat.uv)))
    symmetry = find_symmetry(template)
    even = equalise_seams(pattern, base=template, symmetry=symmetry)
    return CutGarment(garment, opened, pattern, even, equalise_seams(template, symmetry=symmetry), (), ())


def _straighten_mouth(pattern: Pattern, dart: Dart) -> Pattern:
    """Return a pattern whose control point at a closed mouth is on the line between its neighbours."""
    points = pattern.panel(dart.panel).points
    number = dart.first if dart.first < len(points) else dart.first - 1
    before, corner, after = (points[(number + k) % len(points)] for k in (-1, 0, 1))
    chord = after - before
    along = float((corner - before) @ chord) / float(chord @ chord)
    moved = points.copy()
    moved[number] = before + along * chord
    return pattern.with_points({dart.panel: moved})
