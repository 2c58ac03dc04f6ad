"""Predict the ease of a pattern on another body without a drape, and widen the pattern until the ease is kept."""

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


@dataclass(frozen=True)
class WideningSettings:
    """Describe the search for the widening that keeps the ease.

    Attributes:
        tolerance: Change of the ease at which it ends [m], a fiftieth of the tolerance that ease has.
        iterations: Largest number of iterations: two are usual, more where a line at another level becomes shortest.
        step: Widening of a line for the finite differences of the lengths [m].
        max_widening: Largest widening of a line [m], beyond which the search diverged; extreme bodies need half of it.
        rcond: Ratio of a singular value to the largest, below which a combination of widenings changes no ease.
    """

    tolerance: float = 1e-4
    iterations: int = 6
    step: float = 0.01
    max_widening: float = 0.2
    rcond: float = 1e-3


@dataclass(frozen=True)
class EasePrediction:
    """Describe a prediction of a pattern's garment on another body.

    The cloth is where it was on the wearer, both in their T-poses, displaced like the pattern's places; a garment that
    hangs from the waist moves up or down with the waist.

    Attributes:
        garment: The garment on its wearer.
        nodes: Its nodes on the wearer's T-pose [m], shape [node_count, 3].
        ease: Its ease there [m], by place.
        figure: The other body.
        across: Offset of its median plane to the left of the wearer's [m].
        waist: Height of the waist on it in its T-pose [m], or None where the garment hangs from the shoulders.
    """

    garment: Garment
    nodes: np.ndarray
    ease: Mapping[str, float]
    figure: MeasuredBody
    across: float
    waist: float | None

    @classmethod
    def of(cls, garment: Garment, wearer: Body, waist: np.ndarray | None, body: Body) -> EasePrediction:
        """Predict a garment, nodes on its wearer, on another body. `waist` is the curve from which it hangs, on the
        wearer [m], shape [n, 3], or None."""
        figure, nodes = MeasuredBody.of(body), unpose_points(garment.nodes, wearer)
        ease = {one.place: one.value for one in measure_ease(garment, wearer)}
        height = None
        contour = garment.contour("waist")
        if waist is not None and contour is not None:
            # the curve's points are denser on one side than on another: the offset of the cloth's mean height from
            # theirs is kept
            above = nodes[contour.vertices, 1].mean() - unpose_points(waist, wearer)[:, 1].mean()
            height = float(unpose_points(transfer_curve(waist, wearer, body), body)[:, 1].mean() + above)
        return cls(garment, nodes, ease, figure, figure.centre - float(wearer.rest_joints[0, 0]), height)

    def place(self, pattern: Pattern) -> Garment:
        """Return the garment of another pattern, at its predicted place on the other body's T-pose."""
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

    def predict_change(self, pattern: Pattern) -> dict[str, float]:
        """Return the predicted change of the ease on the other body with another pattern [m], by place."""
        found = measure_unposed_ease(cut := self.place(pattern), cut.nodes, self.figure)
        return {one.place: one.value - self.ease[one.place] for one in found if one.place in self.ease}


def max_ease_change(prediction: EasePrediction, pattern: Pattern) -> float:
    """Return the largest predicted change of a pattern's ease on another body [m]."""
    return max((abs(change) for change in prediction.predict_change(pattern).values()), default=0.0)


def preserve_ease(
    pattern: Pattern,
    prediction: EasePrediction,
    rules: Mapping[str, np.ndarray],
    settings: WideningSettings = WideningSettings(),
) -> Pattern:
    """Return a pattern widened until its ease on the other body is that on the wearer, seams equalised.

    Newton's steps with the least-norm, least-squares widening: where fewer places have control points of their own than
    are measured, the changes of the ease are minimised together. Patterns that cannot be cut are discarded.

    Args:
        pattern: The pattern to widen.
        prediction: The prediction on the other body.
        rules: How control points move for a widening at each place (`widening_rules`).
        settings: Of the search.
    """
    moves = np.array(list(rules.values()))

    def cut(widths: np.ndarray) -> Pattern:
        points = pattern.points + np.tensordot(widths, moves, axes=1)
        return equalise_seams(pattern.with_points(points), base=prediction.garment.pattern)

    widths = np.zeros(len(moves))
    best, least = cut(widths), np.inf
    for _ in range(settings.iterations):
        tried = cut(widths)
        now = prediction.predict_change(tried)
        change = np.array(list(now.values()))
        worst = float(np.abs(change).max(initial=0.0))
        if worst < least and np.abs(widths).max() <= settings.max_widening and _has_simple_outlines(tried):
            best, least = tried, worst
        if worst < settings.tolerance:
            break
        slopes = np.zeros((len(now), len(widths)))
        for index, one in enumerate(np.eye(len(widths))):
            wider = prediction.predict_change(cut(widths + settings.step * one))
            slopes[:, index] = [(wider.get(place, was) - was) / settings.step for place, was in now.items()]
        widths -= np.linalg.lstsq(slopes, change, rcond=settings.rcond)[0]
    return best


def _has_simple_outlines(pattern: Pattern) -> bool:
    """Check whether every panel's outline is simple."""
    try:
        for panel in pattern.panels:
            check_outline(panel)
    except BadInput:
        return False
    return True


def _place_uv(pattern: Pattern, uv: np.ndarray, garment: Garment) -> np.ndarray:
    """Return the positions of flat points, across and up, in a pattern's rest placement [m], shape [uv_count, 2]."""
    axes = np.array([panel.rotation[:2, :2] for panel in pattern.panels])[garment.panel_of_uv]
    origins = np.array([panel.translation[:2] for panel in pattern.panels])[garment.panel_of_uv]
    return np.asarray(np.einsum("nij,nj->ni", axes, uv) + origins)
