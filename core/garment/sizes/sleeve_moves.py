"""Move sleeves to another size: wider from the fold to the underarm, longer from the cap's top to the hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..orientation import place_points
from ..pattern import Panel, Pattern
from .arm_points import ArmHalf, arm_coordinates, find_arm_halves
from .bodice_points import find_bodice_points
from .growth import Growth
from .moves import move_panel

ARM_LENGTH_SHARE = 0.332
"""Distance of the wrist from the shoulder as a share of the height (R. Drillis and R. Contini, Body Segment Parameters:
upper arm 0.186, forearm 0.146)."""


def move_sleeves(pattern: Pattern, trunk: Pattern, growth: Growth, height: float, cap_growth: float) -> Pattern:
    """Return a pattern with the trunk of one of its sizes, and its own sleeves moved to that size.

    With s along the arm from the cap's top and t across it from the fold, half a sleeve of width w(s), cap height h
    and length l moves by

        along:   c s / h up to h, from there to l linearly to the growth of the length;
        across:  t / w(s) g(s) / 2,

    where c is the growth of the cap's height and g that of the arm's girth, from the upper arm's down to the wrist's.

    Args:
        pattern: The pattern that is graded.
        trunk: The same with its other panels moved.
        growth: Of the size.
        height: The wearer's height [m].
        cap_growth: Growth of the height of the caps [m].
    """
    panels = {panel.name: panel for panel in trunk.panels}
    halves = find_arm_halves(pattern)
    for name in dict.fromkeys(name for half in halves for name in half.panels):
        own = [half for half in halves if name in half.panels]
        moved = _move_sleeve(pattern, name, own, growth, height, cap_growth)
        panels[name] = replace(moved, translation=moved.translation + _find_shift(pattern, trunk, own[0].sign))
    return replace(trunk, panels=tuple(panels[panel.name] for panel in trunk.panels))


def find_wrist(half: ArmHalf, height: float) -> float:
    """Return the distance of a wearer's wrist along the arm from a cap's top [m], below the underarm point."""
    return max(half.shoulder + ARM_LENGTH_SHARE * height, half.cap_height + 1e-3)


def find_arm_growth(half: ArmHalf, growth: Growth, height: float, along: np.ndarray) -> np.ndarray:
    """Return the growth of a sleeve's girth [m] at some distances along the arm from the cap's top [m]."""
    wrist = find_wrist(half, height)
    found: np.ndarray = np.interp(along, [half.cap_height, wrist], [growth.upper_arm, growth.wrist])
    return found


def find_sleeve_growth(half: ArmHalf, growth: Growth) -> float:
    """Return the growth of a sleeve's length [m], with that of the shoulder where it begins at the neck."""
    shoulder = growth.shoulder if half.shoulder else 0.0
    return shoulder + growth.arm_length + (growth.stature - 1.0) * half.length


def _move_sleeve(
    pattern: Pattern, name: str, halves: list[ArmHalf], growth: Growth, height: float, cap_growth: float
) -> Panel:
    panel = pattern.panel(name)

    def move(points: np.ndarray) -> np.ndarray:
        moves = np.zeros_like(points)
        for half in halves:
            s, t = arm_coordinates(pattern, half, panel, points)
            longer = np.interp(
                s, [0.0, half.cap_height, half.length], [0.0, cap_growth, find_sleeve_growth(half, growth)]
            )
            width = np.interp(s, [half.cap_height, half.length], [half.width, half.end_width])
            wider = 0.5 * find_arm_growth(half, growth, height, s) * t / width
            placed = longer[:, None] * half.along + wider[:, None] * half.across
            own = (t >= 0.0) | (len(halves) == 1)
            moves[own] = (placed @ panel.rotation[:, :2])[own]
        return moves

    return move_panel(panel, move)


def _find_shift(pattern: Pattern, trunk: Pattern, sign: int) -> np.ndarray:
    """Return the mean move of the tips of a shoulder as they are placed [m], shape [3]."""
    moves = []
    for name, i in (face.tips[sign] for face in find_bodice_points(pattern) if sign in face.tips):
        before, after = pattern.panel(name), trunk.panel(name)
        moves.append(place_points(after, after.points[i]) - place_points(before, before.points[i]))
    found: np.ndarray = np.mean(moves, axis=0)
    return found
