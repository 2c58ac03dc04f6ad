"""Grade a pattern without a draft by its named points: cut it along lines through them and spread the parts.

The trade's method (T. Horlamus, Threads 101; N. Schofield and K. LaBat, Clothing and Textiles Research Journal 23):
upright lines between neck, shoulder and side take the width, level lines between shoulder, underarm, waist, hips and
knee the length. Here the opening of each line is spread evenly over the part beside it, so that curves stay smooth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..curves import panel_outline
from ..measures import BodyMeasures
from ..orientation import place_points
from ..panel_parts import find_arm_panels, find_side
from ..pattern import Panel, Pattern
from .bodice_points import find_bodice_points, find_middle
from .figures import NECK_SHARE
from .growth import Growth
from .leg_points import LegPoints, find_leg_points
from .levels import Levels
from .moves import move_panel
from .raglan_points import find_raglan_halves

FORK_SHARES = {"front": 1.0 / 16.0, "back": 1.0 / 8.0}
"""Share of the hips' growth by which the crotch point of a leg's front and back moves inwards (W. Aldrich, Metric
Pattern Cutting for Women's Wear, trouser block; its back's is twice its front's)."""

MIN_HALF_WIDTH = 1e-3
"""Smallest half width of a part by which moves across are shared out [m]."""


def spread_pattern(pattern: Pattern, base: BodyMeasures, growth: Growth) -> Pattern:
    """Return a pattern whose trunk, skirts and legs are graded by their named points; its seams are not closed.

    Args:
        pattern: The pattern, its panels placed on the wearer.
        base: The wearer's measures.
        growth: Of the size.
    """
    levels, arms = Levels.of(pattern, base), find_arm_panels(pattern)
    legs = {leg.panel: leg for leg in find_leg_points(pattern)}
    profile, middle = _Profile.of(pattern, levels, growth), find_middle(pattern)

    def move_down(y: np.ndarray) -> np.ndarray:
        found: np.ndarray = (growth.stature - 1.0) * (y - levels.top) - levels.interpolate_growth(growth, y)
        return found

    def move(panel: Panel) -> Panel:
        leg = legs.get(panel.name)
        if leg is not None and leg.tops is not None:
            return _move_leg(pattern, panel, leg, growth)

        def find_moves(points: np.ndarray) -> np.ndarray:
            placed = place_points(panel, points)
            across = profile.move(placed[:, 0] - middle, placed[:, 1])
            moves: np.ndarray = np.stack([across, move_down(placed[:, 1]), np.zeros(len(points))], axis=1)
            return np.asarray(moves @ panel.rotation[:, :2])

        return move_panel(panel, find_moves)

    lift = np.array([0.0, (growth.stature - 1.0) * levels.top, 0.0])
    panels = [panel if panel.name in arms else move(panel) for panel in pattern.panels]
    return replace(pattern, panels=tuple(replace(p, translation=p.translation + lift) for p in panels))


@dataclass(frozen=True)
class _Profile:
    """Describe how far points of the trunk move sideways.

    Attributes:
        across: Distances of neck, tip and underarm point from the middle, from 0 [m], shape [n]; empty without them.
        moves: How far each moves [m], shape [n].
        underarm: Height of the underarm points [m]; infinite without them.
        heights: Heights from below upwards [m], shape [k].
        sides: How far the side moves there [m], shape [k].
        widths: Half the width of the widest panel there [m], shape [k].
    """

    across: np.ndarray
    moves: np.ndarray
    underarm: float
    heights: np.ndarray
    sides: np.ndarray
    widths: np.ndarray

    @classmethod
    def of(cls, pattern: Pattern, levels: Levels, growth: Growth) -> _Profile:
        """Return the profile of a size."""
        faces, middle = find_bodice_points(pattern), find_middle(pattern)
        knots: dict[str, list[float]] = {name: [] for name in ("necks", "tips", "underarms")}
        for face in faces:
            for name, found in knots.items():
                for panel, i in getattr(face, name).values():
                    own = pattern.panel(panel)
                    found.append(abs(float(place_points(own, own.points[i])[0]) - middle))
        neck = NECK_SHARE * growth.neck
        shoulder = 0.0 if find_raglan_halves(pattern) else growth.shoulder
        grown = {"necks": neck, "tips": neck + shoulder, "underarms": growth.bust / 4.0}
        known = sorted((float(np.mean(found)), grown[name]) for name, found in knots.items() if found)
        heights = np.array([levels.hip, levels.waist, *([] if levels.underarm is None else [levels.underarm])])
        sides = np.array([growth.hip, growth.waist, growth.bust][: len(heights)]) / 4.0
        order = np.argsort(heights)
        fine = np.linspace(min(levels.knee, heights.min()), levels.top, 60)
        fine = np.unique(np.concatenate([fine, heights]))
        widths = _half_widths(pattern, fine, middle)
        return cls(
            np.array([0.0, *(x for x, _ in known)]),
            np.array([0.0, *(more for _, more in known)]),
            np.inf if levels.underarm is None else levels.underarm,
            fine,
            np.interp(fine, heights[order], sides[order]),
            widths,
        )

    def move(self, across: np.ndarray, height: np.ndarray) -> np.ndarray:
        """Return the moves of points with a distance from the middle at a height [m], shape [n]."""
        side = np.interp(height, self.heights, self.sides)
        width = np.maximum(np.interp(height, self.heights, self.widths), MIN_HALF_WIDTH)
        low = np.clip(np.abs(across) / width, 0.0, 1.0) * side
        high = np.interp(np.abs(across), self.across, self.moves)
        found: np.ndarray = np.sign(across) * np.where(height < self.underarm - 1e-9, low, high)
        return found


def _half_widths(pattern: Pattern, heights: np.ndarray, middle: float) -> np.ndarray:
    """Return the largest distance from the middle of panels that are not on arms at some heights [m], shape [n]."""
    arms, reach = find_arm_panels(pattern), np.zeros(len(heights))
    for panel in pattern.panels:
        if panel.name not in arms:
            placed = place_points(panel, panel_outline(panel))
            following = np.roll(placed, -1, axis=0)
            off = np.maximum(np.abs(placed[:, 0] - middle), np.abs(following[:, 0] - middle))
            crossed = (placed[:, 1] - heights[:, None]) * (following[:, 1] - heights[:, None]) <= 0.0
            reach = np.maximum(reach, np.where(crossed, off, 0.0).max(axis=1))
    return reach


def _move_leg(pattern: Pattern, panel: Panel, leg: LegPoints, growth: Growth) -> Panel:
    """Return a panel of a leg: its middle stays at the waist, its crotch point moves inwards, its side outwards, and
    below the crotch both seams move alike from the crease, which halves the way between them."""
    assert leg.tops is not None
    fork_share = FORK_SHARES.get(str(find_side(panel)), FORK_SHARES["back"])
    placed = {ref: place_points(panel, panel.points[ref[1]]) for ref in (leg.fork, *leg.tops, *leg.hems)}
    fork, top, hem = placed[leg.fork], placed[leg.tops[0]], placed[leg.hems[0]]
    side, inward = growth.hip / 4.0, fork_share * growth.hip
    crease, wide = (side - inward) / 2.0, growth.leg / 4.0
    tall = growth.stature - 1.0
    levels = [hem[1], fork[1] + 0.5 * (hem[1] - fork[1]), fork[1], top[1]]
    inner = [crease - wide, crease - wide, -inward, 0.0]
    outer = [crease + wide, crease + wide, side, growth.waist / 4.0]
    outline = place_points(panel, panel_outline(panel))

    def find_moves(points: np.ndarray) -> np.ndarray:
        moves = []
        for x, y, _ in place_points(panel, points):
            near = outline[np.abs(outline[:, 1] - y) < max(0.02, np.abs(outline[:, 1] - y).min() + 1e-9), 0]
            first, last = sorted((near.min(), near.max()), key=lambda value: leg.sign * value)
            share = np.clip((x - first) / (last - first), 0.0, 1.0) if last != first else 0.5
            across = (1.0 - share) * np.interp(y, levels, inner) + share * np.interp(y, levels, outer)
            down = np.clip((top[1] - y) / (top[1] - fork[1]), 0.0, 1.0) * growth.rise
            moves.append([leg.sign * across, tall * (y - top[1]) - down, 0.0])
        found: np.ndarray = np.array(moves) @ panel.rotation[:, :2]
        return found

    return move_panel(panel, find_moves)
