"""Foresee the ease of a pattern on another body without draping it, and widen the pattern until the ease is kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...body.body import Body
from ...garment.control import map_controls
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.seams import equalise_seams
from ...garment.validity import check_outline
from ...run.errors import BadInput
from .ease import MeasuredBody, measure_ease, measure_unposed_ease, unpose_points
from .waist import transfer_curve

EASE_CONVERGENCE_TOLERANCE = 1e-4
"""Change of the ease at which widening ends [m], a fiftieth of what is promised."""

MAX_WIDENING_ITERATIONS = 6
"""Largest number of rounds of widening. Lengths are nearly linear in the control points: two rounds are usual, more
where a line at another level becomes the one that counts."""

WIDENING_DERIVATIVE_STEP = 0.01
"""Widening of a line by which the derivatives of the lengths are taken [m]."""

MAX_LINE_WIDENING = 0.2
"""Largest widening of a line [m]. Between bodies at the ends of the range drafts lack half of that. More is a search
that lost its line, and no result."""

MIN_SINGULAR_VALUE_RATIO = 1e-3
"""Ratio of a singular value to the largest, below which a combination of widenings changes no ease."""


@dataclass(frozen=True)
class EasePrediction:
    """Foresee how a pattern lies on another body.

    The cloth is where it was on the wearer, both in their T-poses, moved by what the pattern's places moved by; what
    hangs from the waist goes up or down with the place of it.

    Attributes:
        garment: The garment on its wearer.
        nodes: Its nodes on the wearer's T-pose [m], shape [node_count, 3].
        ease: Its ease there [m], by place.
        figure: The other body.
        across: How much further left its middle is than the wearer's [m].
        waist: Height of the waist's place on it in its T-pose [m], or None where the garment hangs from the shoulders.
    """

    garment: Garment
    nodes: np.ndarray
    ease: Mapping[str, float]
    figure: MeasuredBody
    across: float
    waist: float | None

    @classmethod
    def of(cls, garment: Garment, wearer: Body, waist: np.ndarray | None, body: Body) -> EasePrediction:
        """Lay a garment on another body.

        Args:
            garment: The garment, nodes on its wearer.
            wearer: The wearer.
            waist: The curve that it hangs from, on the wearer [m], shape [n, 3], or None.
            body: The other body.
        """
        figure, nodes = MeasuredBody.of(body), unpose_points(garment.nodes, wearer)
        ease = {one.place: one.value for one in measure_ease(garment, wearer)}
        height = None
        contour = garment.contour("waist")
        if waist is not None and contour is not None:
            # the curve's points lie closer on one side than on another: how much higher the cloth's mean is stays so
            above = nodes[contour.vertices, 1].mean() - unpose_points(waist, wearer)[:, 1].mean()
            height = float(unpose_points(transfer_curve(waist, wearer, body), body)[:, 1].mean() + above)
        return cls(garment, nodes, ease, figure, figure.centre - float(wearer.rest_joints[0, 0]), height)

    def lay(self, pattern: Pattern) -> Garment:
        """Return the garment cut by another pattern, where it is foreseen to lie on the other body's T-pose."""
        garment = self.garment
        uv = map_controls(garment).apply(pattern.points)
        moves = _place_uv(pattern, uv, garment) - _place_uv(garment.pattern, garment.uv, garment)
        count = np.maximum(np.bincount(garment.uv_node, minlength=len(self.nodes)), 1)
        nodes = self.nodes.copy()
        for axis in (0, 1):
            nodes[:, axis] += np.bincount(garment.uv_node, moves[:, axis], len(nodes)) / count
        nodes[:, 0] += self.across
        contour = garment.contour("waist")
        if self.waist is not None and contour is not None:
            nodes[:, 1] += self.waist - nodes[contour.vertices, 1].mean()
        return replace(garment, pattern=pattern, uv=uv, nodes=nodes)

    def foresee(self, pattern: Pattern) -> dict[str, float]:
        """Return how much more ease the garment has on the other body, cut by another pattern [m], by place."""
        found = measure_unposed_ease(cut := self.lay(pattern), cut.nodes, self.figure)
        return {one.place: one.value - self.ease[one.place] for one in found if one.place in self.ease}


def max_ease_change(laid: EasePrediction, pattern: Pattern) -> float:
    """Return the largest change of the ease that is foreseen for a pattern on another body [m]."""
    return max((abs(change) for change in laid.foresee(pattern).values()), default=0.0)


def preserve_ease(pattern: Pattern, laid: EasePrediction, rules: Mapping[str, np.ndarray]) -> Pattern:
    """Return a pattern widened until its ease on the other body is that on the wearer, seams equalised.

    Newton's steps with the least-norm, least-squares widening: where fewer places have control points of their own than
    are measured, the changes of the ease are made small together. A pattern that cannot be cut is no result.

    Args:
        pattern: What to widen.
        laid: How it lies on the other body.
        rules: How control points move for a widening at each place (`widen_rules`).
    """
    moves = np.array(list(rules.values()))

    def cut(widths: np.ndarray) -> Pattern:
        points = pattern.points + np.tensordot(widths, moves, axes=1)
        return equalise_seams(pattern.with_points(points), like=laid.garment.pattern)

    widths = np.zeros(len(moves))
    best, least = cut(widths), np.inf
    for _ in range(MAX_WIDENING_ITERATIONS):
        tried = cut(widths)
        now = laid.foresee(tried)
        change = np.array(list(now.values()))
        worst = float(np.abs(change).max(initial=0.0))
        if worst < least and np.abs(widths).max() <= MAX_LINE_WIDENING and _has_simple_outlines(tried):
            best, least = tried, worst
        if worst < EASE_CONVERGENCE_TOLERANCE:
            break
        slopes = np.zeros((len(now), len(widths)))
        for index, one in enumerate(np.eye(len(widths))):
            wider = laid.foresee(cut(widths + WIDENING_DERIVATIVE_STEP * one))
            slopes[:, index] = [(wider.get(place, was) - was) / WIDENING_DERIVATIVE_STEP for place, was in now.items()]
        widths -= np.linalg.lstsq(slopes, change, rcond=MIN_SINGULAR_VALUE_RATIO)[0]
    return best


def _has_simple_outlines(pattern: Pattern) -> bool:
    """Return whether every panel's outline is simple."""
    try:
        for panel in pattern.panels:
            check_outline(panel)
    except BadInput:
        return False
    return True


def _place_uv(pattern: Pattern, uv: np.ndarray, garment: Garment) -> np.ndarray:
    """Return where a pattern's first drape places flat points across and up [m], shape [uv_count, 2]."""
    axes = np.array([panel.rotation[:2, :2] for panel in pattern.panels])[garment.panel_of_uv]
    origins = np.array([panel.translation[:2] for panel in pattern.panels])[garment.panel_of_uv]
    return np.asarray(np.einsum("nij,nj->ni", axes, uv) + origins)
