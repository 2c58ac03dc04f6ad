"""Foresee the ease of a pattern on another body without draping it, and widen the pattern until the ease is kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...body import Body
from ...garment import Garment, Pattern, check_outline, equalise_seams, map_controls
from ...run.errors import BadInput
from .ease import Figure, carry_back, ease_at, measure_ease
from .waist import carry_curve

MET = 1e-4
"""Change of the ease at which widening ends [m], a fiftieth of what is promised."""

ROUNDS = 6
"""Most rounds of widening. Lengths are nearly linear in the control points: two are usual, more where a line at another
level becomes the one that counts."""

STEP = 0.01
"""Widening by which the lengths' derivatives are taken [m]."""

MOST = 0.2
"""Largest widening of a line [m]: between bodies at the ends of the range drafts lack half of that; more is a search
that lost its line, and no result."""

WEAKEST = 1e-3
"""Singular value, relative to the largest, below which a combination of widenings changes no ease."""


@dataclass(frozen=True)
class Laid:
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
    figure: Figure
    across: float
    waist: float | None

    @classmethod
    def of(cls, garment: Garment, wearer: Body, waist: np.ndarray | None, body: Body) -> Laid:
        """Lay a garment on another body.

        Args:
            garment: The garment, nodes on its wearer.
            wearer: The wearer.
            waist: The curve that it hangs from, on the wearer [m], shape [n, 3], or None.
            body: The other body.
        """
        figure, nodes = Figure.of(body), carry_back(garment.nodes, wearer)
        ease = {one.place: one.value for one in measure_ease(garment, wearer)}
        height = None
        contour = garment.contour("waist")
        if waist is not None and contour is not None:
            # the curve's points lie closer on one side than on another: how much higher the cloth's mean is stays so
            above = nodes[contour.vertices, 1].mean() - carry_back(waist, wearer)[:, 1].mean()
            height = float(carry_back(carry_curve(waist, wearer, body), body)[:, 1].mean() + above)
        return cls(garment, nodes, ease, figure, figure.centre - float(wearer.rest_joints[0, 0]), height)

    def lay(self, pattern: Pattern) -> Garment:
        """Return the garment cut by another pattern, where it is foreseen to lie on the other body's T-pose."""
        garment = self.garment
        uv = map_controls(garment).apply(pattern.points)
        moves = _places(pattern, uv, garment) - _places(garment.pattern, garment.uv, garment)
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
        found = ease_at(cut := self.lay(pattern), cut.nodes, self.figure)
        return {one.place: one.value - self.ease[one.place] for one in found if one.place in self.ease}


def largest_change(laid: Laid, pattern: Pattern) -> float:
    """Return the largest change of the ease that is foreseen for a pattern on another body [m]."""
    return max((abs(change) for change in laid.foresee(pattern).values()), default=0.0)


def keep_ease(pattern: Pattern, laid: Laid, rules: Mapping[str, np.ndarray]) -> Pattern:
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
    for _ in range(ROUNDS):
        tried = cut(widths)
        now = laid.foresee(tried)
        change = np.array(list(now.values()))
        worst = float(np.abs(change).max(initial=0.0))
        if worst < least and np.abs(widths).max() <= MOST and _can_be_cut(tried):
            best, least = tried, worst
        if worst < MET:
            break
        slopes = np.zeros((len(now), len(widths)))
        for index, one in enumerate(np.eye(len(widths))):
            wider = laid.foresee(cut(widths + STEP * one))
            slopes[:, index] = [(wider.get(place, was) - was) / STEP for place, was in now.items()]
        widths -= np.linalg.lstsq(slopes, change, rcond=WEAKEST)[0]
    return best


def _can_be_cut(pattern: Pattern) -> bool:
    """Return whether every panel's outline is simple."""
    try:
        for panel in pattern.panels:
            check_outline(panel)
    except BadInput:
        return False
    return True


def _places(pattern: Pattern, uv: np.ndarray, garment: Garment) -> np.ndarray:
    """Return where a pattern's first drape places flat points across and up [m], shape [uv_count, 2]."""
    axes = np.array([panel.rotation[:2, :2] for panel in pattern.panels])[garment.panel_of_uv]
    origins = np.array([panel.translation[:2] for panel in pattern.panels])[garment.panel_of_uv]
    return np.asarray(np.einsum("nij,nj->ni", axes, uv) + origins)
