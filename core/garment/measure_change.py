"""Adapt a pattern to other measures: move its control points by the difference of two drafts, or scale its panels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .pattern import Panel, Pattern
from .seams import equalise_seams


def move_by_drafts(pattern: Pattern, old: Pattern, new: Pattern) -> Pattern | None:
    """Return a pattern with control points p + D(m1) - D(m0), D the draft for measures m, and seams made equal.

    The drafts give a grade rule for each control point. Handles are relative and follow, also on edges that are
    straight in the draft and were recovered as curves; the panels' placement moves too.

    Args:
        pattern: The pattern that fits m0.
        old, new: The drafts D(m0) and D(m1).

    Returns:
        The pattern for m1, or None where control points of pattern and drafts do not correspond.
    """
    if [(panel.name, len(panel.points)) for panel in old.panels] != [(p.name, len(p.points)) for p in pattern.panels]:
        return None
    triples = zip(pattern.panels, old.panels, new.panels, strict=True)
    return equalise_seams(replace(pattern, panels=tuple(_move(*panels) for panels in triples)), base=pattern)


def scale_panels(pattern: Pattern, across: float, along: float) -> Pattern:
    """Return a pattern without a draft for other measures: each panel scaled about its middle, seams made equal.

    Args:
        pattern: The pattern.
        across: Factor around the body.
        along: Factor along the body: of the panel's axis that is placed upright.
    """
    panels = []
    for panel in pattern.panels:
        upright = np.abs(panel.rotation[1, :2])
        factors = np.where(upright == upright.max(), along, across)
        middle = panel.points.mean(axis=0)
        points = middle + factors * (panel.points - middle)
        panels.append(replace(panel, points=points, translation=panel.translation * along))
    return equalise_seams(replace(pattern, panels=tuple(panels)), base=pattern)


def _move(panel: Panel, old: Panel, new: Panel) -> Panel:
    return replace(
        panel,
        points=panel.points + new.points - old.points,
        translation=panel.translation + new.translation - old.translation,
    )
