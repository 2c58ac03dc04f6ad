"""Names of the edges and control points of a pattern as a tailor says them: `armhole`, `high point of the shoulder`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..orientation import place_points
from ..panel_parts import Side, find_arm_panels, find_side
from ..pattern import EdgeRef, Panel, Pattern
from .pattern_lines import OPEN_LINE_NAMES
from .seam_names import name_seam

ARMHOLE_SEAM_NAMES: Mapping[bool, str] = MappingProxyType({True: "sleeve cap", False: "armhole"})
"""Names of both sides of an armhole seam: of the panel on the arm, and of the other."""

CORNER_NAMES: Mapping[frozenset[str], str] = MappingProxyType({
    frozenset({"neckline", "shoulder seam"}): "high point of the shoulder (HPS)",
    frozenset({"neck seam", "shoulder seam"}): "high point of the shoulder (HPS)",
    frozenset({"armhole", "shoulder seam"}): "shoulder point",
    frozenset({"armhole edge", "shoulder seam"}): "shoulder point",
    frozenset({"armhole", "side seam"}): "underarm point",
    frozenset({"armhole edge", "side seam"}): "underarm point",
    frozenset({"sleeve cap", "sleeve seam"}): "underarm point",
    frozenset({"sleeve cap", "overarm seam"}): "top of the sleeve cap",
})  # fmt: skip
"""Names of control points by the names of the edges that meet there; others are named by both edges."""

MIDDLE_NAMES: Mapping[Side, str] = MappingProxyType({Side.FRONT: "CF", Side.BACK: "CB"})
"""Names of the wearer's middle by the side of a panel: centre front and centre back."""

MIDDLE_TOLERANCE = 0.005
"""Largest distance from the wearer's middle of a point of centre front or centre back [m]: half of a seam's allowance,
within which panels of a sewn garment are placed."""


@dataclass(frozen=True)
class PanelNames:
    """Describe the names of one panel's edges, and of the control points at which they begin.

    Attributes:
        lines: A name for each edge; an empty text where neither a seam nor an open edge of it has one.
        sides: The wearer's side of each edge whose name two lines of the panel have: `left`, `right`, or an empty text.
        points: A name for each control point; an empty text within a line.
    """

    lines: tuple[str, ...]
    sides: tuple[str, ...]
    points: tuple[str, ...]


def name_edges(pattern: Pattern) -> dict[str, PanelNames]:
    """Return the names of the edges and control points of each panel."""
    arms = find_arm_panels(pattern)
    found: dict[EdgeRef, tuple[str, str]] = {}
    for seam in pattern.seams:
        name, side = name_seam(pattern, seam).name, name_seam(pattern, seam).side
        for ref in (seam.a, seam.b):
            found[ref] = ARMHOLE_SEAM_NAMES[ref.panel in arms] if name == "armhole seam" else name, side
    for panel in pattern.panels:
        for i, edge in enumerate(panel.edges):
            word, _, side = edge.contour.partition(".")
            if word:
                found[EdgeRef(panel.name, i)] = OPEN_LINE_NAMES.get(word, word), side
    x = np.concatenate([place_points(panel, panel.points)[:, 0] for panel in pattern.panels])
    middle = float(x.min() + x.max()) / 2.0
    names = {}
    for panel in pattern.panels:
        pairs = [found.get(EdgeRef(panel.name, i), ("", "")) for i in range(len(panel.edges))]
        lines = tuple(line for line, _ in pairs)
        sides = tuple(side if len({s for line, s in pairs if line == own}) > 1 else "" for own, side in pairs)
        names[panel.name] = PanelNames(lines, sides, _name_points(panel, lines, middle, panel.name in arms))
    return names


def _name_points(panel: Panel, lines: tuple[str, ...], middle: float, is_arm: bool) -> tuple[str, ...]:
    """Return the names of a panel's control points; `middle` is x of the wearer's."""
    apart = place_points(panel, panel.points)[:, 0] - middle
    spans = not is_arm and apart.min() < -MIDDLE_TOLERANCE and apart.max() > MIDDLE_TOLERANCE
    names = []
    for i, after in enumerate(lines):
        before = lines[i - 1]
        pair = (before, after)
        is_crossed = spans and abs(apart[i]) < MIDDLE_TOLERANCE and "inseam" not in pair
        if is_crossed or _is_at_middle(pair):
            name = _name_middle(panel, pair)
        elif before == after or not before or not after:
            name = ""
        else:
            name = CORNER_NAMES.get(frozenset(pair), " and ".join(sorted(pair)))
        names.append(name)
    return tuple(
        f"{'left' if apart[i] > 0.0 else 'right'} {name}" if names.count(name) > 1 and name else name
        for i, name in enumerate(names)
    )


def _is_at_middle(pair: tuple[str, str]) -> bool:
    """Check whether one of two lines that meet runs along the wearer's middle and the other does not, nor an inseam."""
    along = [line.startswith("centre") or line.endswith("crotch seam") for line in pair]
    return along[0] != along[1] and all(pair) and "inseam" not in pair


def _name_middle(panel: Panel, pair: tuple[str, str]) -> str:
    word = MIDDLE_NAMES.get(find_side(panel), "")
    line = next((line for line in pair if line and not line.startswith("centre") and "crotch" not in line), "")
    return f"{word} of the {line}" if word and line else word or line
