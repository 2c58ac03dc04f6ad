"""Divide a base pattern's girth between front and back as the corners of the scan's hems show."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...body.body import Body
from ...garment.curves import edge_length
from ...garment.pattern import Pattern
from ...garment.seams import equalise_seams
from ...scan.contours.edge_turn import EdgeTurn
from ...scan.contours.target import Contour, Target

MIN_PANEL_WIDTH_CHANGE = 0.02
"""Relative change of a panel's width above which the base pattern is changed: 5 mm of a quarter of the hip, the
accuracy of a corner's place on a mesh of 1 cm."""

MAX_PANEL_WIDTH_CHANGE = 0.30
"""Relative change of a panel's width above which two corners are not taken for seams: fronts and backs of published
trousers differ by up to a half at the hem, a quarter each from their mean."""


@dataclass(frozen=True)
class HemShare:
    """Describe how a contour is divided by its two corners.

    Attributes:
        contour: Its name.
        front: The front's share of its length.
        turns: Angles of both corners [rad].
    """

    contour: str
    front: float
    turns: tuple[float, float]

    def describe(self) -> str:
        """Return one sentence for the user."""
        first, second = np.abs(np.degrees(self.turns))
        return (
            f"Corners of {first:.0f} and {second:.0f} degrees show where side seams end at the contour "
            f"'{self.contour}': {100 * self.front:.0f} % of it are in front; the base pattern was divided so."
        )


def share_by_hems(base: Pattern, target: Target, body: Body) -> tuple[Pattern, tuple[HemShare, ...]]:
    """Return a base pattern with the ratio of front and back widths that the scan's hems show.

    Where a slanted side seam meets a hem that was cut straight, the hem has a corner. It is visible in the cloth
    whatever its folds: the angles of the surface around a point of its edge sum up to less than pi, or to more. A
    smooth side hides its seam everywhere else, and grading keeps the base pattern's proportions of front and back, so
    these have to be right before. Each panel and what is sewn above it is scaled across; the sum of both widths stays.

    Only for garments that hang from the waist, whose hems each have one panel in front and one behind. Where hems show
    no corners, not two, or the base pattern's own ratio, the pattern is returned unchanged.

    Args:
        base: The base pattern.
        target: The scan's surface with named contours.
        body: The wearer, whose hips define the front.

    Returns:
        The pattern, and the shares that changed it; none where it is `base` itself.
    """
    found: list[HemShare] = []
    factors: dict[str, list[float]] = {}
    names = {edge.contour for panel in base.panels for edge in panel.edges if edge.contour}
    for contour in target.contours:
        lengths = _lengths(base, contour.name)
        if "neck" in names or contour.name == "waist" or not contour.trusted or len(lengths) != 2:
            continue
        seen = find_hem_share(contour, target, body)
        if seen is None:
            continue
        front, back = sorted(lengths, key=lambda name: -float(base.panel(name).translation[2]))
        whole = lengths[front] + lengths[back]
        found.append(seen)
        for name, share in ((front, seen.front), (back, 1.0 - seen.front)):
            factors.setdefault(_facing_side(base, name), []).append(share * whole / lengths[name])
    if not found:
        return base, ()
    means = {face: float(np.mean(each)) for face, each in factors.items()}
    change = max(abs(factor - 1.0) for factor in means.values())
    if not MIN_PANEL_WIDTH_CHANGE < change < MAX_PANEL_WIDTH_CHANGE:
        return base, ()
    return _scale(base, means), tuple(found)


def find_hem_share(contour: Contour, target: Target, body: Body) -> HemShare | None:
    """Find the two corners of a target's edge, one at each side; None where it has not exactly these."""
    edge = EdgeTurn.of_target(contour, target)
    corners = edge.corners()
    if len(corners) != 2:
        return None
    first, second = sorted(edge.places[corners])
    lateral = body.sideways("hip")
    forward, sideways = edge.points @ np.cross(lateral, (0.0, 1.0, 0.0)), edge.points @ lateral
    if abs(np.diff(sideways[corners])) < abs(np.diff(forward[corners])):
        return None
    between = (edge.places > first) & (edge.places < second)
    share = float((second - first) / edge.length)
    front = share if forward[between].mean() > forward[~between].mean() else 1.0 - share
    return HemShare(contour.name, front, (float(edge.turn[corners[0]]), float(edge.turn[corners[1]])))


def _lengths(base: Pattern, contour: str) -> dict[str, float]:
    """Return the length of a contour on each panel that has a part of it [m]."""
    lengths: dict[str, float] = {}
    for panel in base.panels:
        for i, edge in enumerate(panel.edges):
            if edge.contour == contour:
                lengths[panel.name] = lengths.get(panel.name, 0.0) + edge_length(panel, i)
    return lengths


def _facing_side(base: Pattern, name: str) -> str:
    """Return on which side of the wearer a panel is placed."""
    return "front" if float(base.panel(name).translation[2]) > 0.0 else "back"


def _scale(base: Pattern, factors: dict[str, float]) -> Pattern:
    """Return a pattern whose front and back panels are scaled across about their middles, seams made equal."""
    panels = []
    for panel in base.panels:
        upright = np.abs(panel.rotation[1, :2])
        factor = np.where(upright == upright.max(), 1.0, factors[_facing_side(base, panel.name)])
        middle = (panel.points.min(axis=0) + panel.points.max(axis=0)) / 2
        panels.append(replace(panel, points=middle + factor * (panel.points - middle)))
    return equalise_seams(replace(base, panels=tuple(panels)), base=base)
