"""Draft skirts that hang from the natural waist. Straight, pencil and A-line skirts are the basic skirt block of W.
Aldrich, Metric Pattern Cutting for Women's Wear, without its darts: the waist is shaped at the side seams. Circle
skirts are sectors of a ring whose inner arc is the waist; of n panels each has an n-th of the whole angle. Gathered and
tiered skirts are rectangles (H. Joseph-Armstrong, Patternmaking for Fashion Design), each wider than the edge it is
gathered into."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

from ..measures import BodyMeasures
from ..outline import (
    Outline,
    Point,
    Stroke,
    arc_handles,
    draw_monotone_spline,
    labelled_length,
    mirror,
    place_panel,
    reverse_strokes,
    unfold,
    unfold_closed,
)
from ..pattern import Panel
from .cut import Bodice, Cut, Gores, PartsConflict, Shaping, Skirt, Waistband, Yoke
from .gores import Gore, draw_gores
from .pleats import draw_pleats, yoke_strokes
from .shaping import Waistline, share_waist
from .upper_edge import UpperEdge
from .vents import cut_back

WAISTBAND_WIDTH = 0.04
"""Width of a waistband [m]: as stiff as two layers of cloth, it still follows the waist."""

ELASTIC_GATHER_RATIO = 1.4
"""Ratio of a waist's length to that of the elastic band it is gathered into, 1.3 to 1.5: that of hips to
waist, so that the cloth passes the hips (H. Joseph-Armstrong, Patternmaking for Fashion Design, pull-on waists)."""

CIRCLE_SKIRT_ANGLES = {Skirt.HALF_CIRCLE: math.pi, Skirt.FULL_CIRCLE: 2 * math.pi}
"""Whole angle of a circle skirt [rad]."""

CIRCLE_LENGTH = 0.50
"""Length of a circle skirt from waist to hem [m]: to above the knee."""


SKIRT_GATHER_RATIO = 1.5
"""Ratio of the width of a gathered skirt's upper edge to that of the edge it is gathered into: a medium fullness."""

SKIRT_TIER_HEIGHTS = (0.16, 0.18, 0.20)
"""Heights of a tiered skirt's rectangles from the top [m]; by convention each is longer than the one above."""

YOKE_DEPTH = 0.11
"""Height of a hip yoke [m]: to the hip bones, above the widest place."""

YOKE_REACH = 0.62
"""Share of the difference between hip and waist girth at a hip yoke's lower edge: that of bodies at that height."""

DART_DEPTH = {"front": 0.09, "back": 0.13}
"""Length of a skirt's darts [m]: the belly is higher than the seat."""

DARTED_SKIRTS = (Skirt.STRAIGHT, Skirt.PENCIL, Skirt.A_LINE)
"""Skirts that darts shape; others are wider below the waist than any body."""


def draw_skirt(cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw the panels of a skirt, of its hip yoke and of its waistband; below a bodice, of a skirt to be sewn to it.

    Raises:
        PartsConflict: where the number of panels is not drafted, a gathered skirt has nothing to be gathered into, or
            the skirt cannot have its darts or yoke.
    """
    _check(cut)
    waist = half_waist(cut, m) / 2
    name = "band" if cut.waistband is not Waistband.NONE else "waist" if cut.bodice is not Bodice.NONE else ""
    edge = UpperEdge(name, waist, m.waist_height, share_waist(cut))
    panels = []
    if cut.waistband is not Waistband.NONE:
        panels = [draw_band(face, waist, edge.height, edge.shares, cut.waistband) for face in ("front", "back")]
    if cut.waistband is Waistband.ELASTIC and cut.skirt not in (Skirt.GATHERED, Skirt.TIERED):
        edge = replace(edge, quarter=ELASTIC_GATHER_RATIO * waist)
    if cut.yoke is Yoke.HIP:
        low = waist + YOKE_REACH * ((m.hip + 0.04) / 4 - waist)
        panels = [_hip_yoke(face, edge, low, cut.skirt) for face in ("front", "back")] + panels
        edge = UpperEdge("hipyoke", low, edge.height - YOKE_DEPTH)
    if cut.skirt in CIRCLE_SKIRT_ANGLES:
        return _circle(CIRCLE_SKIRT_ANGLES[cut.skirt], edge) + panels
    if cut.skirt is Skirt.TIERED:
        return _tiers(edge) + panels
    if cut.skirt is Skirt.PLEATED:
        return draw_pleats(edge.quarter, edge.height) + panels
    if cut.has_equal_gores:
        return draw_gores(edge, Gore.of(cut, edge.quarter, m)) + panels
    if cut.skirt is Skirt.GORED:
        return _six_gores(edge, cut, m) + panels
    return (_two_panels if cut.panels == 2 else _four_panels)(edge, cut, m) + panels


def _check(cut: Cut) -> None:
    """Check that a skirt's parts have what they are sewn to."""
    sewn = cut.waistband is not Waistband.NONE or cut.bodice is not Bodice.NONE
    if cut.skirt is not Skirt.GORED and cut.gores is not Gores.SIX:
        raise PartsConflict("gores are a gored skirt's; choose skirt=gored.")
    if cut.panels not in (2, 4):
        raise PartsConflict(f"a skirt of {cut.panels} panels is not drafted; choose 2 or 4.")
    if cut.skirt in (*CIRCLE_SKIRT_ANGLES, Skirt.TIERED, Skirt.PLEATED) and cut.panels != 2:
        raise PartsConflict(f"a {cut.skirt} skirt is drafted of 2 panels.")
    if cut.skirt in (Skirt.GATHERED, Skirt.TIERED) and not sewn and cut.yoke is not Yoke.HIP:
        raise PartsConflict(
            f"a {cut.skirt} skirt needs something to be gathered into; add waistband=band, waist=seam or yoke=hip."
        )
    if cut.waistband is Waistband.ELASTIC and (cut.yoke is Yoke.HIP or cut.shaping is not Shaping.NONE):
        raise PartsConflict("an elastic waist has neither yoke nor darts; choose waistband=band, or leave these out.")
    if cut.skirt is Skirt.PLEATED and cut.yoke is not Yoke.HIP:
        raise PartsConflict("a pleated skirt is drafted on a yoke; add yoke=hip.")
    if cut.yoke is Yoke.HIP and cut.skirt in (*DARTED_SKIRTS, Skirt.GORED):
        raise PartsConflict(f"a {cut.skirt} skirt has no yoke; choose a gathered, tiered, pleated or circle one.")
    if cut.bodice is Bodice.NONE and cut.yoke.faces:
        raise PartsConflict(f"a yoke={cut.yoke} is a bodice's; choose yoke=hip.")
    if cut.bodice is not Bodice.NONE:
        if cut.skirt is Skirt.GORED and cut.has_equal_gores == cut.is_shaped_by_seams:
            raise PartsConflict(
                "six gores meet a bodice's darts or princess seams, others none; choose shaping=darts or "
                "shaping=princess with gores=6, or gores=8."
            )
        return
    if cut.shaping is Shaping.PRINCESS:
        raise PartsConflict("princess seams begin at the shoulders; of a skirt choose skirt=gored, or shaping=darts.")
    if cut.shaping is Shaping.DARTS and cut.skirt not in DARTED_SKIRTS:
        raise PartsConflict(f"a {cut.skirt} skirt has nothing for darts to take in.")


def half_waist(cut: Cut, m: BodyMeasures) -> float:
    """Return half of the waist's girth [m]: body + 2 cm where the skirt hangs from it, and the body's own in an elastic
    band. Below a bodice + 10 cm, and + 6 cm where that is shaped to the waist."""
    ease = 0.02 if cut.bodice is Bodice.NONE else 0.10 if cut.shaping is Shaping.NONE else 0.06
    if cut.waistband is Waistband.ELASTIC:
        ease = 0.0
    return (m.waist + ease) / 2


def _silhouette(cut: Cut, waist: float, m: BodyMeasures) -> list[Point]:
    """Return the points of a side seam from the hem to the waist [m]. Allowances: waist + 2 cm. A-line: hip + 5 cm, hem
    1.30 m wide, 54 cm long; of four panels hip + 6 cm, hem 1.72 m, 58 cm. Pencil: hip + 4 cm, 50 cm long, the hem 6 cm
    narrower than the hip line. Straight: the same with a hem as wide as the hip line."""
    hip_line = m.hip_height - m.waist_height
    if cut.skirt is Skirt.A_LINE and cut.panels == 4:
        return [(0.37, -0.58), ((m.hip + 0.06) / 4, hip_line), (waist, 0.0)]
    if cut.skirt is Skirt.A_LINE:
        return [(0.325, -0.54), ((m.hip + 0.05) / 4, hip_line), (waist, 0.0)]
    hip = (m.hip + 0.04) / 4
    narrower = 0.015 if cut.skirt is Skirt.PENCIL else 0.0
    return [(hip - narrower, -0.50), (hip, hip_line), (waist, 0.0)]


def _rectangle(edge: UpperEdge, m: BodyMeasures) -> list[Point]:
    """Return the side of a gathered skirt: a rectangle `SKIRT_GATHER_RATIO` as wide as the edge it is gathered into."""
    wide = SKIRT_GATHER_RATIO * edge.quarter
    return [(wide, -0.54), (wide, min(m.hip_height - edge.height, -0.1)), (wide, 0.0)]


def _waist_line(edge: UpperEdge, line: Waistline, dip: float, rise: float, face: str) -> list[Stroke]:
    """Draw half a waist from the side to the middle: sewn and straight, open and dipping there, or with a dart."""
    if line.dart:
        apex = -DART_DEPTH[face]
        across = reverse_strokes(Outline((0.0, 0.0), line.strokes(face, 0.0, apex)))
        return [_rename(stroke, edge) for stroke in across]
    if edge.name:
        return edge.strokes(face, (line.half, 0.0), Stroke((0.0, 0.0)))
    wide = line.half
    return edge.strokes(face, (wide, 0.0), Stroke((0.0, -dip), ((wide * 0.6, rise - dip), (wide * 0.3, -dip))))


def _rename(stroke: Stroke, edge: UpperEdge) -> Stroke:
    """Return a stroke of a darted waist with the labels of the skirt, whose darts differ from the bodice's."""
    if stroke.label.startswith("dart."):
        return replace(stroke, label=f"skirt{stroke.label}")
    if not edge.name:
        return replace(stroke, label="", contour="waist")
    return replace(stroke, label=stroke.label.replace("waist", edge.name, 1))


def _own_darts(edge: UpperEdge, cut: Cut, hip: float) -> Waistline:
    """Return a skirt's waist, with darts where these shape it."""
    if cut.shaping is Shaping.DARTS and cut.skirt in DARTED_SKIRTS:
        waistline = Waistline.of(cut, edge.quarter + (hip - edge.quarter) / 2, edge.quarter)
        return replace(waistline, dart=min(waistline.dart, 0.03))
    return Waistline(edge.quarter, 0.0, 0.0)


def _two_panels(edge: UpperEdge, cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw front and back. An open waist dips by 12 mm at the middle and an A-line hem by 15 mm, so that both meet the
    slanted side seams nearly at a right angle and the hem hangs level."""
    gathered = cut.skirt is Skirt.GATHERED
    points = _rectangle(edge, m) if gathered else _silhouette(cut, edge.quarter, m)
    line = Waistline(points[-1][0], 0.0, 0.0) if gathered else _own_darts(edge, cut, points[1][0])
    points[-1] = (line.half, 0.0)
    dip = 0.015 if cut.skirt is Skirt.A_LINE else 0.0
    panels = []
    for face in ("front", "back"):
        strokes = draw_monotone_spline(points, ["side.0.left", "side.1.left"])
        strokes += _waist_line(edge, line, 0.012, 0.002, face)
        whole = unfold(Outline(points[0], tuple(strokes)), "hem", dip=dip)
        pieces = cut_back(cut, face, whole) if face == "back" else [(face, whole)]
        panels += [place_panel(part, outline, edge.height) for part, outline in pieces]
    return panels


def _four_panels(edge: UpperEdge, cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw left and right of front and back, sewn at the centre, which has a third of an A-line panel's flare."""
    gathered = cut.skirt is Skirt.GATHERED
    points = _rectangle(edge, m) if gathered else _silhouette(cut, edge.quarter, m)
    line = Waistline(points[-1][0], 0.0, 0.0) if gathered else _own_darts(edge, cut, points[1][0])
    points[-1] = (line.half, 0.0)
    hip_line, (wide, low) = points[1][1], points[0]
    centre = (-0.06, low - 0.02) if cut.skirt is Skirt.A_LINE else (0.0, low)
    panels = []
    for face in ("front", "back"):
        outline = Outline(
            (wide, low),
            (
                *draw_monotone_spline(points, ["side.0.left", "side.1.left"]),
                *_waist_line(edge, line, 0.010, 0.001, face),
                Stroke((0.0, hip_line), label=f"centre.{face}.0"),
                Stroke(centre, label=f"centre.{face}.1"),
                Stroke((wide, low), contour="hem"),
            ),
        )
        panels.append(place_panel(f"{face}_left", outline, edge.height))
        panels.append(place_panel(f"{face}_right", mirror(outline), edge.height))
    return panels


GORE_FLARE = 0.03
"""Flare of each side of a gore's seam at the hem [m]: six gores share the flare among six seams."""


GORE_RISE = 0.02
"""Height of a gored hem at the side over that at the gore seams [m], so that it hangs level."""


def _six_gores(edge: UpperEdge, cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw a centre and two side gores in front and behind, as wide at waist and hip as an A-line skirt of two panels.
    `DART_SHARE` of the surplus between hip and waist is taken in at the gore seam, the rest at the side seam."""
    shaped = replace(cut, skirt=Skirt.A_LINE, shaping=Shaping.DARTS)
    (wide, low), (hip, hip_line), _ = _silhouette(shaped, edge.quarter, m)
    line = _own_darts(edge, shaped, hip)
    sides = [(wide, low + GORE_RISE), (hip, hip_line), (line.half, 0.0)]
    gaps = [(-GORE_FLARE, low), (0.0, hip_line), (line.dart / 2, 0.0)]
    panels = []
    for face in ("front", "back"):
        seam = [f"gore.{face}.0.left", f"gore.{face}.1.left"]
        inner = draw_monotone_spline([(line.centre - gap, y) for gap, y in gaps], seam)
        outer = draw_monotone_spline([(line.centre + gap, y) for gap, y in gaps], seam)
        top = _waist_line(edge, line, 0.0, 0.0, face)  # side, both sides of the dart, middle
        start, end = (line.centre - gaps[0][0], low), (line.centre + gaps[0][0], low)
        middle = Outline(start, (*inner, top[-1]))
        beside = Outline(
            end,
            (
                Stroke(sides[0], contour="hem"),
                *draw_monotone_spline(sides, ["side.0.left", "side.1.left"]),
                top[0],
                *reverse_strokes(Outline(end, tuple(outer))),
            ),
        )
        panels.append(place_panel(face, unfold(middle, "hem", dip=0.008), edge.height))
        panels.append(place_panel(f"{face}_side_left", beside, edge.height))
        panels.append(place_panel(f"{face}_side_right", mirror(beside), edge.height))
    return panels


def _tiers(edge: UpperEdge) -> list[Panel]:
    """Draw front and back of each tier: rectangles, each gathered by `SKIRT_GATHER_RATIO` into the one above."""
    panels, above = [], edge
    for number, high in enumerate(SKIRT_TIER_HEIGHTS):
        wide = SKIRT_GATHER_RATIO * above.quarter
        for face in ("front", "back"):
            last = number == len(SKIRT_TIER_HEIGHTS) - 1
            bottom = (
                Stroke((wide, -high), contour="hem")
                if last
                else Stroke((wide, -high), label=f"tier{number}.{face}.left")
            )
            strokes = (
                bottom,
                Stroke((wide, 0.0), label=f"side.{number}.left"),
                *above.strokes(face, (wide, 0.0), Stroke((0.0, 0.0))),
            )
            outline = unfold_closed(Outline((0.0, -high), strokes))
            panels.append(place_panel(f"tier{number}_{face}", outline, above.height))
        above = UpperEdge(f"tier{number}", wide, above.height - high)
    return panels


def _hip_yoke(face: str, edge: UpperEdge, low: float, skirt: Skirt) -> Panel:
    """Draw front or back of a hip yoke, whose lower quarter is `low` [m], divided where a skirt's pleats meet it."""
    plain = (Stroke((low, -YOKE_DEPTH), label=f"hipyoke.{face}.left"),)
    strokes = (
        *(yoke_strokes(face, low, -YOKE_DEPTH) if skirt is Skirt.PLEATED else plain),
        Stroke((edge.quarter, 0.0), label="yokeside.left"),
        *edge.strokes(face, (edge.quarter, 0.0), Stroke((0.0, 0.0))),
    )
    outline = unfold_closed(Outline((0.0, -YOKE_DEPTH), strokes))
    return place_panel(f"yoke_{face}", outline, edge.height)


def _circle(sweep: float, edge: UpperEdge) -> list[Panel]:
    """Draw front and back of a circle skirt, each half of the sector; waist and hem are concentric."""
    half = sweep / 4
    radius = edge.quarter / _cubic_arc(half)
    outer = radius + CIRCLE_LENGTH

    def at(distance: float, angle: float) -> Point:
        """Return a point of the sector, whose axis points down from the waist's middle."""
        return (distance * math.sin(angle), radius - distance * math.cos(angle))

    cuts = [half * i / 2 for i in range(3)]
    strokes = [
        Stroke(at(outer, b), arc_handles(at(outer, a), at(outer, b), b - a), contour="hem") for a, b in pairwise(cuts)
    ]
    strokes.append(Stroke(at(radius, half), label="side.left"))
    start, top = at(radius, half), at(radius, 0.0)
    arc = Stroke(top, arc_handles(start, top, -half))
    panels = []
    for face in ("front", "back"):
        outline = unfold_closed(Outline(at(outer, 0.0), (*strokes, *edge.strokes(face, start, arc))))
        panels.append(place_panel(face, outline, edge.height))
    return panels


def _cubic_arc(angle: float) -> float:
    """Return the length of the cubic for an arc of radius 1, which is exactly the length of the edge sewn to it."""
    start, end = (0.0, 0.0), (math.sin(angle), 1.0 - math.cos(angle))
    return labelled_length(Outline(start, (Stroke(end, arc_handles(start, end, angle), label="arc"),)), "arc")


def draw_band(
    face: str,
    half: float,
    height: float,
    shares: tuple[float, ...] = (1.0,),
    kind: Waistband = Waistband.BAND,
) -> Panel:
    """Draw half a waistband, `half` to each side of the middle [m], divided at the centre, darts and gores. The casing
    of an elastic band has the elastic's length as worn."""
    edge = UpperEdge("band", half, height, shares)
    down = edge.strokes(face, (half, 0.0), Stroke((0.0, 0.0)))
    out = Outline((0.0, 0.0), reverse_strokes(Outline((half, 0.0), tuple(down))))
    strokes = (
        *mirror(out).strokes,
        *out.strokes,
        Stroke((half, WAISTBAND_WIDTH), label="bandside.left"),
        Stroke((-half, WAISTBAND_WIDTH), contour="waist"),
        Stroke((-half, 0.0), label="bandside.right"),
    )
    label = "elastic band" if kind is Waistband.ELASTIC else "band"
    return place_panel(f"band_{face}", Outline((-half, 0.0), strokes), height, label=label)
