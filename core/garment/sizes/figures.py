"""Figures of a garment that a grade table has, each a sum of coordinates of named points, with the rule it grows by."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from ..measures import BodyMeasures
from ..orientation import place_points
from ..panel_parts import MIDDLE_REACH, Side
from ..pattern import EdgeRef, Pattern
from .arm_points import ArmHalf, find_arm_halves, is_cap_low
from .bodice_points import (
    LEFT_SIGN,
    RIGHT_SIGN,
    FacePoints,
    PointRef,
    find_bodice_points,
    find_face_panels,
    find_hems,
    find_middle,
    is_armhole,
)
from .growth import Growth
from .leg_points import find_leg_points
from .levels import Levels
from .raglan_points import RaglanHalf, find_arm_axes, find_raglan_halves, find_raglan_throat, find_shares
from .sleeve_moves import find_wrist

ACROSS_AXIS, UP_AXIS = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
"""Directions in which panels of the trunk are measured: towards the wearer's left, and up [1]."""

NECK_SHARE = 1.0 / 5.0
"""Share of the neck's girth in half a neckline's width, and in its depth in front (W. Aldrich, Metric Pattern Cutting
for Women's Wear: the bodice block's neck)."""

MIN_FIGURE_RATE = 1e-3
"""Smallest growth of a figure with its steps at which its points are told apart [m for steps of 1 m]."""

SIDE_POINT_REACH = 0.02
"""Largest distance of a point of a side seam from the height of the waist or the hips that it gives [m]."""

Terms = list[tuple[PointRef, np.ndarray]]
"""Points, each with a vector as placed, shape [3]."""


@dataclass(frozen=True)
class Rule:
    """Describe by how much a figure grows: shares of the growth of measures, and whether it follows the stature."""

    shares: Mapping[str, float]
    follows_stature: bool = False

    def grow(self, growth: Growth, length: float) -> float:
        """Return the growth of a figure of a length [m]."""
        tall = (growth.stature - 1.0) * length if self.follows_stature else 0.0
        return tall + sum(share * float(getattr(growth, name)) for name, share in self.shares.items())

    def describe(self, with_stature: bool = True) -> str:
        """Return the rule in words: `2/5 of neck`; without the stature where it does not change."""
        parts = [_describe_share(name, share) for name, share in self.shares.items() if abs(share) > 1e-3]
        return " + ".join([*parts, *(["stature"] if self.follows_stature and with_stature else [])]) or "none"


@dataclass(frozen=True)
class Figure:
    """Describe a figure.

    Attributes:
        name: In words: `chest`, `armhole depth, front`.
        rule: By which it grows.
        terms: The figure is the sum of the products of points and vectors [m].
        steps: Moves of points, of any length, by which it is changed.
    """

    name: str
    rule: Rule
    terms: Terms = field(default_factory=list)
    steps: Terms = field(default_factory=list)

    def row(self, pattern: Pattern) -> np.ndarray:
        """Return the figure's derivative by all coordinates x0, y0, x1, ... of a pattern, shape [2 point_count]."""
        return _spread(pattern, self.terms)

    def value(self, pattern: Pattern) -> float:
        """Return the figure of a pattern, beside a constant of its placement [m]."""
        return float(self.row(pattern) @ pattern.points.ravel())

    def rate(self, pattern: Pattern) -> float:
        """Return by how much the figure grows with its steps [m]."""
        return float(self.row(pattern) @ _spread(pattern, self.steps))

    def change(self, pattern: Pattern, more: float) -> Pattern:
        """Return a pattern with the figure larger by some length [m]; curves follow their control points."""
        step = more / self.rate(pattern) * _spread(pattern, self.steps)
        return pattern.with_points(pattern.points + step.reshape(-1, 2))


def find_figures(pattern: Pattern, base: BodyMeasures, height: float) -> tuple[Figure, ...]:
    """Return the figures of a pattern, in the order in which rules are applied to it.

    Args:
        pattern: The pattern that is graded.
        base: Its wearer's measures.
        height: The wearer's height [m].
    """
    levels = Levels.of(pattern, base)
    faces = find_bodice_points(pattern)
    found = [figure for face in faces for figure in _find_face_figures(pattern, face, levels)]
    if faces and all(len(face.underarms) == 2 for face in faces):
        across = [(face.underarms[sign], sign * ACROSS_AXIS) for face in faces for sign in (LEFT_SIGN, RIGHT_SIGN)]
        found.append(Figure("chest", Rule({"bust": 1.0}), across, across))
    found += _find_sleeve_figures(find_arm_halves(pattern), height)
    legs = _find_leg_figures(pattern)
    found += legs if legs and not faces else [*_find_trunk_figures(pattern, levels), *legs]
    return tuple(figure for figure in found if figure.rate(pattern) > MIN_FIGURE_RATE)


def _find_face_figures(pattern: Pattern, face: FacePoints, levels: Levels) -> list[Figure]:
    """Return the figures of the front or the back of a bodice."""
    side, found = str(face.face), []
    if len(face.necks) == 2:
        across = [(face.necks[sign], sign * ACROSS_AXIS) for sign in (LEFT_SIGN, RIGHT_SIGN)]
        tips = [(face.tips[sign], sign * ACROSS_AXIS) for sign in (LEFT_SIGN, RIGHT_SIGN)]
        found.append(Figure(f"neck width, {side}", Rule({"neck": 2.0 * NECK_SHARE}), across, [*across, *tips]))
    terms: Terms = []
    for sign, neck in face.necks.items():
        along = _find_shoulder_direction(pattern, face, sign)
        terms += [(face.tips[sign], along / len(face.necks)), (neck, -along / len(face.necks))]
    if terms:
        found.append(Figure(f"shoulder seam, {side}", Rule({"shoulder": 1.0}), terms, terms[::2]))
    pairs = [(face.tips[sign], face.underarms[sign]) for sign in face.tips]
    down = [(under, -UP_AXIS / len(pairs)) for _, under in pairs]
    terms = [*((tip, UP_AXIS / len(pairs)) for tip, _ in pairs), *down]
    found.append(Figure(f"armhole depth, {side}", Rule({"armhole_depth": 1.0}, True), terms, down))
    tops = [(neck, UP_AXIS / len(face.necks)) for neck in face.necks.values()]
    if tops and face.throat:
        shares = {"neck": NECK_SHARE} if face.face is Side.FRONT else {}
        low = [(ref, -UP_AXIS / len(face.throat)) for ref in face.throat]
        found.append(Figure(f"neck depth, {side}", Rule(shares), [*tops, *low], low))
    raglans = [half for half in find_raglan_halves(pattern) if half.face is face.face]
    if len(raglans) == 2:
        found += _find_raglan_neck(pattern, raglans, find_raglan_throat(pattern, face))
        tops = [(half.tip, UP_AXIS / 2.0) for half in raglans]
    if tops and face.hems:
        low = [(ref, -UP_AXIS / len(face.hems)) for ref in face.hems]
        height = float(np.mean([_place(pattern, ref)[1] for ref in face.hems]))
        found.append(Figure(f"length, {side}", Rule(levels.find_shares(height), True), [*tops, *low], low))
    return found


def _find_raglan_neck(pattern: Pattern, halves: list[RaglanHalf], throat: tuple[PointRef, ...]) -> list[Figure]:
    """Return the figures of a neckline whose sides belong to raglan sleeves: trunk and sleeves grow by their shares."""
    side, wide, wide_steps, deep, deep_steps = str(halves[0].face), *([], [], [], [])
    for half in halves:
        along, across = find_arm_axes(pattern, half)
        width, depth = find_shares(pattern, half, throat)
        wide += [(half.tip, half.sign * ACROSS_AXIS), (half.top, along), (half.neck, -along)]
        wide_steps += [(half.tip, half.sign * width * ACROSS_AXIS), (half.neck, (width - 1.0) * along)]
        deep += [(half.tip, 0.5 * UP_AXIS), (half.neck, 0.5 * across), (half.top, -0.5 * across)]
        deep += [(ref, -0.5 / len(throat) * UP_AXIS) for ref in throat]
        deep_steps += [(half.neck, (1.0 - depth) * across), *((ref, -0.5 * depth * UP_AXIS) for ref in throat)]
    found = [Figure(f"neck width, {side}", Rule({"neck": 2.0 * NECK_SHARE}), wide, wide_steps)]
    if throat:
        shares = {"neck": NECK_SHARE} if halves[0].face is Side.FRONT else {}
        found.append(Figure(f"neck depth, {side}", Rule(shares), deep, deep_steps))
    return found


def _find_trunk_figures(pattern: Pattern, levels: Levels) -> list[Figure]:
    """Return girths at waist, hips and hem, where outlines have points there, and the length of a skirt."""
    found = []
    sides = (Side.FRONT, Side.BACK)
    for name, height in (("waist", levels.waist), ("hip", levels.hip)):
        ends = [ref for face in sides for ref in _find_outer_points(pattern, face, height)]
        found += _make_girth(name, Rule({name: 1.0}), pattern, ends)
    hems = {face: find_hems(pattern, face) for face in sides}
    low = [ref for refs in hems.values() for ref in refs]
    if not low or not all(hems.values()):
        return found
    height = float(np.mean([_place(pattern, ref)[1] for ref in low]))
    outer = [ref for refs in hems.values() for ref in _find_outermost(pattern, refs)]
    found += _make_girth("hem", Rule(levels.find_girth_shares(height)), pattern, outer)
    if levels.underarm is None:
        tops = [ref for face in sides for ref in _find_outer_points(pattern, face, levels.top)]
        if tops:
            below = [(ref, -UP_AXIS / len(low)) for ref in low]
            terms = [*((ref, UP_AXIS / len(tops)) for ref in tops), *below]
            found.append(Figure("length", Rule(levels.find_shares(height), True), terms, below))
    return found


def _make_girth(name: str, rule: Rule, pattern: Pattern, ends: list[PointRef]) -> list[Figure]:
    """Return the figure of a girth between points of both sides; none where a side of a face lacks one."""
    if len(ends) != 4:
        return []
    middle = find_middle(pattern)
    across = [(ref, np.sign(_place(pattern, ref)[0] - middle) * ACROSS_AXIS) for ref in ends]
    return [Figure(name, rule, across, across)]


def _find_outer_points(pattern: Pattern, face: Side, height: float) -> list[PointRef]:
    """Return the outermost control points of a face at a height [m], at both sides."""
    near = [
        (panel.name, i)
        for panel in find_face_panels(pattern, face)
        for i, y in enumerate(place_points(panel, panel.points)[:, 1])
        if abs(y - height) < SIDE_POINT_REACH
    ]
    return _find_outermost(pattern, near)


def _find_outermost(pattern: Pattern, refs: Collection[PointRef]) -> list[PointRef]:
    """Return the points furthest to either side of the wearer; one or none where a side has none."""
    middle = find_middle(pattern)
    by_x = sorted((float(_place(pattern, ref)[0]) - middle, ref) for ref in refs)
    if not by_x or by_x[0][0] > -MIDDLE_REACH or by_x[-1][0] < MIDDLE_REACH:
        return []
    return [by_x[0][1], by_x[-1][1]]


def _find_sleeve_figures(halves: tuple[ArmHalf, ...], height: float) -> list[Figure]:
    """Return the figures of the sleeves, means of both arms."""
    if not halves:
        return []
    arms = len({half.sign for half in halves})
    wide: Terms = [(half.under, half.across / arms) for half in halves]
    long: Terms = [(ref, half.along / len(halves)) for half in halves for ref in half.ends[:1] if ref != half.top]
    long = long or [(half.ends[1], half.along / len(halves)) for half in halves]
    ends = [(ref, side * half.across / arms) for half in halves for ref, side in zip(half.ends, (-1, 1), strict=True)]
    first = halves[0]
    wrist = find_wrist(first, height)
    share = float(np.interp(first.length, [first.cap_height, wrist], [0.0, 1.0]))
    tops: Terms = [(half.top, -half.across / arms) for half in halves]
    backs: Terms = [(half.top, -half.along / len(halves)) for half in halves]
    lower = ends[1::2]
    both: Terms = [(ref, half.along) for half in halves for ref in half.ends if ref != half.top]
    lengths = {"shoulder": 1.0, "arm_length": 1.0} if first.shoulder else {"arm_length": 1.0}
    bicep = Figure("bicep", Rule({"upper_arm": 1.0}), [*wide, *tops], wide)
    return [
        *([] if is_cap_low(halves) else [bicep]),
        Figure("sleeve length", Rule(lengths, True), [*long, *backs], both),
        Figure("sleeve end", Rule({"upper_arm": 1.0 - share, "wrist": share}), ends, lower),
    ]


def _find_leg_figures(pattern: Pattern) -> list[Figure]:
    """Return the figures of the legs, means of both."""
    legs = find_leg_points(pattern)
    if not legs:
        return []
    count, found = len({leg.sign for leg in legs}), []
    below: Terms = [(leg.fork, -UP_AXIS / len(legs)) for leg in legs]
    if all(leg.tops for leg in legs):
        above = [(ref, UP_AXIS / (2 * len(legs))) for leg in legs for ref in leg.tops or ()]
        found.append(Figure("rise", Rule({"rise": 1.0}, True), [*above, *below], above))
        waist = [
            (ref, w * leg.sign * ACROSS_AXIS) for leg in legs for ref, w in zip(leg.tops or (), (-1, 1), strict=True)
        ]
        found.append(Figure("waist", Rule({"waist": 1.0}), waist, waist))
        hips = [(leg.hip, leg.sign * ACROSS_AXIS) for leg in legs if leg.hip is not None]
        if len(hips) == len(legs):
            found.append(Figure("hip", Rule({"hip": 1.0}), hips, hips))
    low = [(ref, -UP_AXIS / (2 * len(legs))) for leg in legs for ref in leg.hems]
    found.append(Figure("inseam", Rule({}, True), [*((ref, -step) for ref, step in below), *low], low))
    for name, pairs in (("knee", [leg.knees for leg in legs]), ("leg hem", [leg.hems for leg in legs])):
        known = [pair for pair in pairs if pair is not None]
        if len(known) == len(legs):
            wide = [
                (ref, side * leg.sign * ACROSS_AXIS / count)
                for leg, pair in zip(legs, known, strict=True)
                for ref, side in zip(pair, (-1, 1), strict=True)
            ]
            found.append(Figure(name, Rule({"leg": 1.0}), wide, wide))
    return found


def _find_shoulder_direction(pattern: Pattern, face: FacePoints, sign: int) -> np.ndarray:
    """Return the direction of a shoulder seam towards its tip as placed, shape [3]: that of its last edge."""
    name, at = face.tips[sign]
    panel = pattern.panel(name)
    count = len(panel.points)
    ends = {1: EdgeRef(name, at), -1: EdgeRef(name, (at - 1) % count)}
    step = next(step for step, ref in ends.items() if not is_armhole(pattern, ref))
    outward = panel.rotation[:, :2] @ (panel.points[at] - panel.points[(at + step) % count])
    found: np.ndarray = outward / np.linalg.norm(outward)
    return found


def _spread(pattern: Pattern, terms: Terms) -> np.ndarray:
    """Return vectors as placed in the coordinates of all control points, shape [2 point_count]."""
    row = np.zeros((len(pattern.points), 2))
    for (name, i), vector in terms:
        row[pattern.first_points[name] + i] += vector @ pattern.panel(name).rotation[:, :2]
    return row.ravel()


def _place(pattern: Pattern, ref: PointRef) -> np.ndarray:
    panel = pattern.panel(ref[0])
    placed: np.ndarray = place_points(panel, panel.points[ref[1]])
    return placed


def _describe_share(name: str, share: float) -> str:
    words = name.replace("_", " ")
    if abs(share - 1.0) < 1e-3:
        return words
    near = Fraction(share).limit_denominator(20)
    return f"{near} of {words}" if abs(float(near) - share) < 1e-3 else f"{share:.2f} of {words}"
