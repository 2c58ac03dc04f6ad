"""Draft legs: trousers and shorts that hang from the waist, and suits whose legs continue into a bodice. The
construction is the classic trouser block (W. Aldrich, Metric Pattern Cutting for Women's Wear): a crease line that
halves each panel, forks of a sixteenth and an eighth of the hip girth, a back that rises higher than the front and
whose fork is dropped until the inseams are equal."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..curves import edge_length
from ..measures import BodyMeasures
from ..outline import Outline, Point, Stroke, draw_monotone_spline, labelled_length, mirror, place_panel, to_point
from ..pattern import Panel
from .cut import Cut, Legs, PartsConflict, Shaping, Waistband
from .gathers import LEG_GATHER_RATIO
from .skirts import ELASTIC_GATHER_RATIO, WAISTBAND_WIDTH, draw_band, half_waist
from .tops import FACES, Shoulder, draw_shoulder

CREASE_FROM_MIDDLE = 0.12
"""Initial distance of a leg's crease line from the middle [m]: outside the ankles, so that panels stay on one side."""

_EASED_SEAMS = ("inseam.0", "outseam.1", "outseam.2")
"""Seams of the trousers whose back is fitted to the front."""

KNEE_HEIGHT_SHARE = 0.47 / 0.79
"""Height of the knee above the feet as a share of the crotch's height: 47 cm on the body of the drafts."""

LEG_HEM_HEIGHT = 0.08
"""Height above the feet of a long leg's hem [m]: clear of the floor for any length of leg."""

LEG_GIRTHS = {
    Legs.STRAIGHT: (0.45, 0.40),
    Legs.TAPERED: (0.42, 0.33),
    Legs.FLARED: (0.42, 0.54),
    Legs.WIDE: (0.58, 0.60),
}
"""Girths of a long leg at knee and hem [m]: a hem of 33 cm still passes the heel."""

LEGGINGS_GIRTH_RATIO = 0.90
"""Ratio of the girths of leggings to the wearer's: a knit that stretches by 25 % (moderate by the stretch gauge of H.
Joseph-Armstrong, Patternmaking for Fashion Design) is then stretched across by 11 %."""

LEG_GIRTH_SHARES = ((0.47 / 0.79, 0.373), (0.38 / 0.79, 0.360), (0.11 / 0.79, 0.230))
"""Height of knee, calf and ankle above the feet as a share of the crotch's height, and girth there as a share of the
hip's: those of the built-in female body of 1.70 m, 37, 36 and 23 cm."""

LegEnd = tuple[float, float]
"""Height above the feet of a cut across the leg, and half the mean of front and back width there [m]."""


@dataclass(frozen=True)
class LegCut:
    """Describe the cut of legs above and below the crotch; heights are above the natural waist [m].

    Attributes:
        hip, waist: Girths [m].
        crotch, top: Heights of the crotch and of the upper edge.
        forks: Lengths of the front and the back fork [m].
        ends: Cuts across the leg from the knee down.
    """

    hip: float
    waist: float
    crotch: float
    top: float
    forks: tuple[float, float]
    ends: tuple[LegEnd, ...]

    @classmethod
    def of(cls, cut: Cut, m: BodyMeasures) -> LegCut:
        """Return the cut of trousers, shorts or leggings.

        Raises:
            PartsConflict: where leggings, which have no fullness, are to be gathered.
        """
        banded = -WAISTBAND_WIDTH if cut.waistband is not Waistband.NONE else 0.0
        if cut.legs is Legs.LEGGINGS:
            if cut.waistband is Waistband.ELASTIC:
                raise PartsConflict("leggings hold by their own stretch; choose waistband=band or waistband=none.")
            hip, waist = LEGGINGS_GIRTH_RATIO * m.hip, LEGGINGS_GIRTH_RATIO * m.waist
            ends = tuple((height * m.crotch_height, share * hip / 4) for height, share in LEG_GIRTH_SHARES)
            return cls(hip, waist, m.crotch_height - m.waist_height, banded, (hip / 24, hip / 12), ends)
        if cut.legs is Legs.SHORT:
            ends = ((m.crotch_height - 0.205, 0.1475),)
        else:
            knee, hem = LEG_GIRTHS[cut.legs]
            ends = ((KNEE_HEIGHT_SHARE * m.crotch_height, knee / 4), (LEG_HEM_HEIGHT, hem / 4))
        forks, crotch = (m.hip / 16 - 0.01, m.hip / 8 - 0.02), m.crotch_height - 0.015 - m.waist_height
        if cut.shaping is Shaping.GATHERS:
            return cls(m.hip + 0.06, LEG_GATHER_RATIO * (m.waist + 0.02), crotch, banded, forks, ends)
        if cut.waistband is Waistband.ELASTIC:
            return cls(m.hip + 0.06, ELASTIC_GATHER_RATIO * m.waist, crotch, banded, forks, ends)
        return cls(m.hip + 0.06, m.waist + 0.06, crotch, -0.06, forks, ends)


def draw_legs(cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw front and back of each leg of trousers, shorts or leggings.

    Allowances: the waist is 6 cm below the natural waist, where the girth is about waist + 6 cm; hip + 6 cm, the front
    1 cm narrower and the back 1 cm wider than a quarter, measured a third of the rise above the crotch; crotch 1.5 cm
    below the body's; forks of hip / 16 - 1 cm (front) and hip / 8 - 2 cm (back), the seat's depth; knee and hem of
    `LEG_GIRTHS`. Shorts: inseam 19 cm, legs 59 cm around, 4 cm more than the thigh there. In an elastic band the waist
    is at the natural one, `ELASTIC_GATHER_RATIO` of its girth; gathered into another band, of waist + 2 cm, it is
    there too, `LEG_GATHER_RATIO` of the band. Leggings: from the natural waist to the ankle, with
    `LEGGINGS_GIRTH_RATIO` of the body's girths, the crotch at the body's, and forks of a 24th and a 12th of their hip,
    for the knit stretches over the seat. The back fork is lowered and the back's side corners moved until inseams and
    outseams are equal.

    Raises:
        PartsConflict: where the legs cannot have their waistband.
    """
    from scipy.optimize import root  # a slow import, not needed to read templates

    legs, base = LegCut.of(cut, m), m.waist_height
    front = _leg(legs, base, side_shift=-0.01, fork=legs.forks[0], rise=0.0, fork_drop=0.0, lift=(0.0, 0.0))

    def back(drop: float, hip_lift: float, side_lift: float) -> Outline:
        lift = (hip_lift, side_lift)
        return _leg(legs, base, side_shift=0.01, fork=legs.forks[1], rise=0.02, fork_drop=drop, lift=lift)

    def excess(moves: np.ndarray) -> np.ndarray:
        drawn = back(*moves)
        return np.array([labelled_length(drawn, name) - labelled_length(front, name) for name in _EASED_SEAMS])

    solved = root(excess, np.zeros(len(_EASED_SEAMS)), tol=1e-9)
    panels = []
    for side, outline in (("front", front), ("back", back(*solved.x))):
        crease = (
            sum(
                p.end[0]
                for p in outline.strokes
                if p.label == f"inseam.{len(legs.ends) - 1}.left" or p.contour == "leg.left"
            )
            / 2
        )
        named = replace(outline, strokes=tuple(_on_side(s, side) for s in outline.strokes))
        for leg, drawn in (("left", named), ("right", mirror(named))):
            across = CREASE_FROM_MIDDLE - crease if leg == "left" else crease - CREASE_FROM_MIDDLE
            panels.append(place_panel(f"{side}_{leg}", drawn, base, label="leg", across=across))
    if cut.waistband is not Waistband.NONE:
        fullness = ELASTIC_GATHER_RATIO if cut.waistband is Waistband.ELASTIC else 1.0
        if cut.shaping is Shaping.GATHERS:
            fullness = LEG_GATHER_RATIO
        panels = [_sew_to_waistband(panel) for panel in panels]
        for side in FACES:
            waist = next(panel for panel in panels if panel.name == f"{side}_left")
            waist_edge = next(i for i, edge in enumerate(waist.edges) if edge.label.startswith("band"))
            half = edge_length(waist, waist_edge) / fullness
            panels.append(draw_band(side, half, base + legs.top, kind=cut.waistband))
    return panels


def _sew_to_waistband(panel: Panel) -> Panel:
    """Return a leg's panel with its waist sewn to a band."""
    face, leg = panel.name.split("_")
    edges = tuple(
        replace(edge, label=f"band.{face}.{leg}", contour="") if edge.contour == "waist" else edge
        for edge in panel.edges
    )
    return replace(panel, edges=edges)


def _leg(
    legs: LegCut,
    base: float,
    *,
    side_shift: float,
    fork: float,
    rise: float,
    fork_drop: float,
    lift: tuple[float, float],
) -> Outline:
    """Draw one left leg panel around its crease line, which halves the distance from fork to side. `base` is the height
    of the natural waist [m]."""
    crotch, top = legs.crotch, legs.top
    hip = crotch + (top - crotch) / 3
    side = legs.hip / 4 + side_shift
    waist = legs.waist / 4 + side_shift / 2
    crease = (side - fork) / 2
    slant = 1.4 * rise + 0.01
    cuts = [(height - base, half + side_shift / 2) for height, half in legs.ends]
    tip = (-fork, crotch - fork_drop)
    centre = (slant, top + rise)
    seat = (0.0, hip)
    first = (crease - cuts[0][1], cuts[0][0])
    strokes = [
        Stroke(seat, label="crotch.0"),
        Stroke(tip, ((0.0, hip + 0.62 * (crotch - hip)), (-0.45 * fork, tip[1] + 0.002)), label="crotch.1"),
        Stroke(first, _inseam_handles(tip, first, 0.10, 0.30), label="inseam.0.left"),
    ]
    strokes += [Stroke((crease - half, y), label=f"inseam.{i}.left") for i, (y, half) in enumerate(cuts[1:], start=1)]
    strokes.append(Stroke((crease + cuts[-1][1], cuts[-1][0]), contour="leg.left"))
    lower = ["outseam.0.left", "outseam.0.calf.left"][: len(cuts) - 1]
    strokes += [Stroke((crease + half, y), label=label) for (y, half), label in zip(cuts[-2::-1], lower, strict=True)]
    thigh = [(crease + cuts[0][1], cuts[0][0]), (side, hip + lift[0]), (slant + waist, top + lift[1])]
    strokes += draw_monotone_spline(thigh, ["outseam.1.left", "outseam.2.left"])
    strokes.append(Stroke(centre, contour="waist"))
    return Outline(centre, tuple(strokes))


def draw_suit(cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw front and back of each half of a suit in one piece, from the shoulder to the ankle, and its sleeves.
    Allowances: waist + 16 cm (it is put on through the neck), below it those of `_draw_halves`."""
    shoulder = draw_shoulder(cut, m)
    return _draw_halves(cut, m, shoulder) + shoulder.collar(cut, m) + shoulder.sleeves(cut, m.nape_height)


def draw_suit_legs(cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw front and back of each leg of a suit below its waist seam, which is as long as the bodice's."""
    return _draw_halves(cut, m, half_waist(cut, m) / 2)


def _draw_halves(cut: Cut, m: BodyMeasures, above: Shoulder | float) -> list[Panel]:
    """Draw front and back of both halves of a suit, up to the shoulder or to a waist with quarters of a given length
    [m]. Allowances: hip + 12 cm and crotch 4 cm below the body's, so that the trunk can bend; straight legs of 47 cm at
    the knee and 42 cm at the hem, others differ from these as trousers' do. Side seams are one curve; the back's fork
    is lowered until the inseams are equal."""
    from scipy.optimize import brentq

    if cut.legs not in LEG_GIRTHS:
        raise PartsConflict(f"legs={cut.legs} are not cut with a bodice; choose straight, tapered, flared or wide.")
    knee, hem = (girth - usual for girth, usual in zip(LEG_GIRTHS[cut.legs], LEG_GIRTHS[Legs.STRAIGHT], strict=True))
    wider = (knee / 8, hem / 8)
    front = _half_suit(m, 0, m.hip / 16 - 0.01, 0.0, above, wider)
    length = labelled_length(front, "inseam.0")

    def back(drop: float) -> Outline:
        return _half_suit(m, 1, m.hip / 8 - 0.025, drop, above, wider)

    drop = brentq(lambda moved: labelled_length(back(moved), "inseam.0") - length, -0.05, 0.15, xtol=1e-12)
    panels = []
    for side, outline in (("front", front), ("back", back(drop))):
        panels.append(place_panel(f"{side}_left", outline, m.nape_height))
        panels.append(place_panel(f"{side}_right", mirror(outline), m.nape_height))
    return panels


def _half_suit(
    m: BodyMeasures, face: int, fork: float, fork_drop: float, above: Shoulder | float, wider: tuple[float, float]
) -> Outline:
    """Draw the left half of a suit's front (0) or back (1) around the leg's middle, 13 cm from the body's. `above` is
    the shoulder that its waist continues into, or a quarter of the waist to which it is sewn [m]; `wider` is the
    distance of each side seam at knee and hem from a straight leg's [m]."""
    base, side = m.nape_height, FACES[face]
    hip, waist, crotch = m.hip_height + 0.04 - base, m.waist_height - base, m.crotch_height - 0.04 - base
    fork_tip = (-fork, crotch - fork_drop)
    knee, ankle = KNEE_HEIGHT_SHARE * m.crotch_height - base, LEG_HEM_HEIGHT - base
    sides = [
        (0.245 + wider[1], ankle),
        (0.25 + wider[0], knee),
        ((m.hip + 0.12) / 4, m.hip_height - base),
    ]
    if isinstance(above, Shoulder):
        sides += [((m.waist + 0.16) / 4, waist), above.underarm]
        upper, centre = above.strokes(face), [Stroke((0.0, waist), label=f"centre.{side}.0")]
    else:
        sides.append((above, waist))
        upper, centre = [Stroke((0.0, waist), label=f"waist.{side}.left")], []
    inner = (0.015 - wider[0], knee)
    strokes = (
        *centre,
        Stroke((0.0, hip), label=f"centre.{side}.1"),
        Stroke(
            fork_tip,
            ((0.0, hip + 0.62 * (crotch - hip)), (-0.45 * fork, fork_tip[1] + 0.002)),
            label=f"crotch.{side}",
        ),
        Stroke(inner, _inseam_handles(fork_tip, inner, 0.10, 0.30), label="inseam.0.left"),
        Stroke((0.035 - wider[1], ankle), label="inseam.1.left"),
        Stroke(sides[0], contour="leg.left"),
        *draw_monotone_spline(sides, [f"side.{i}.left" for i in range(len(sides) - 1)]),
        *upper,
    )
    return Outline(upper[-1].end, strokes)


def _inseam_handles(start: Point, end: Point, at_start: float, at_end: float) -> tuple[Point, ...]:
    """Return handles of an inseam that leaves the fork flat and arrives along the leg's line."""
    a, b = np.array(start), np.array(end)
    gap = b - a
    return (
        to_point(a + np.array([0.55, 0.0]) * gap * 0.5 + np.array([0.0, at_start]) * gap),
        to_point(b - np.array([0.0, at_end]) * gap),
    )


def _on_side(stroke: Stroke, side: str) -> Stroke:
    """Label front and back crotch seams apart: front is sewn to front."""
    if not stroke.label.startswith("crotch"):
        return stroke
    return replace(stroke, label=stroke.label.replace("crotch", f"crotch.{side}"))
