"""Draft bodices: front and back from the shoulder to a hem at the hips or, cut in one with a skirt, at the knee. All
are blocks for planar placement: front and back are placed before and behind the body, and half sleeves continue them in
the same plane, so that a flattened body in T-pose fits between."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..measures import BodyMeasures
from ..outline import (
    Outline,
    Point,
    Stroke,
    cut_stroke,
    draw_monotone_spline,
    labelled_length,
    place_panel,
    reverse_strokes,
    unfold,
    unfold_closed,
)
from ..pattern import Panel
from .collars import STRIP_COLLARS, sew_collar, strip_collar
from .cut import (
    Bodice,
    Collar,
    Cut,
    Front,
    HemBand,
    Hood,
    Legs,
    PartsConflict,
    Shaping,
    Skirt,
    Sleeve,
    SleeveHead,
    SleevePieces,
    Waist,
)
from .fronts import cut_front
from .gathers import BLOUSON_OVERHANG
from .hoods import draw_hood, sew_hood
from .necklines import NecklineCut, draw_neckline, side_neck
from .ribs import HEM_RIB_WIDTH
from .shaping import APEX_BELOW, PRINCESS_SEAM_FLARE, Waistline, draw_princess
from .skirts import half_waist
from .sleeves import SLEEVES, SleeveEnd, half_sleeves, raglan_sleeves, set_in_caps, two_piece_sleeves
from .turned_collars import LAPELLED_COLLARS, TURNED_COLLARS, sew_lapel, turned_collar
from .vents import cut_back
from .wraps import WRAP_LABEL, divide_side, draw_wrap
from .yokes import cut_yoke, divide_armhole

FACES = ("front", "back")

PLACED_INWARD = 0.09
"""Distance by which the side panels of princess seams are placed towards the middle [m]; welding moves them back."""

RAGLAN_SHARE = (0.35, 0.5)
"""Share of half a neckline, in front and behind, that a raglan sleeve takes: its seam then slants to the underarm from
the hollow of the collarbone in front and from beside the nape behind."""

STRAPLESS_DROP = 0.03
"""Distance of a strapless bodice's upper edge below the armpit [m]: that of a sleeveless armhole."""

HALTER_STRAP = 0.033
"""Width of a halter at its shoulder seam [m]: its armholes are cut in to beside the neck, in front and behind."""

DROPPED_SHOULDER_REACH = 0.05
"""Length by which a dropped shoulder reaches over the arm [m]."""

UNDER_SHARE = 0.35
"""Share of each armhole that the under sleeve of a sleeve of two pieces is sewn to: its seams then begin at the front
and back pitch points, a third of the armhole above the underarm."""


@dataclass(frozen=True)
class Shoulder:
    """Describe the upper ends of a bodice's front and back.

    Attributes:
        neck: Side neck point [m].
        tip: Shoulder's tip [m].
        underarm: Underarm point, where the side seam ends [m].
        armholes: From the underarm point to the shoulder's tip, of the front and of the back.
        necklines: From the side neck point to the middle, of the front and of the back.
        head: How sleeves meet it.
    """

    neck: Point
    tip: Point
    underarm: Point
    armholes: tuple[tuple[Stroke, ...], tuple[Stroke, ...]]
    necklines: tuple[tuple[Stroke, ...], tuple[Stroke, ...]]
    head: SleeveHead = SleeveHead.FLAT

    def strokes(self, face: int) -> list[Stroke]:
        """Return armhole, shoulder seam and neckline of the front (0) or the back (1), from the side to the middle."""
        if self.head is SleeveHead.RAGLAN:
            neck, line = self._raglan(face)
            return [line, *neck[1:]]
        return [*self.armholes[face], Stroke(self.neck, label="shoulder.left"), *self.necklines[face]]

    def collar(self, cut: Cut, m: BodyMeasures) -> list[Panel]:
        """Return the panels of the collar or the hood that is sewn to the necklines; none where there is neither."""
        if cut.collar in STRIP_COLLARS:
            return strip_collar(cut, self.neck, self.necklines, m.nape_height)
        if cut.collar in TURNED_COLLARS:
            return turned_collar(cut, self.neck, self.necklines, m.nape_height)
        return draw_hood(cut, m, self.neck, self.necklines) if cut.hood is not Hood.NONE else []

    def sleeves(self, cut: Cut, height: float) -> list[Panel]:
        """Return the half sleeves of both arms, with their cuffs; none where there is no sleeve.

        Raises:
            PartsConflict: where the sleeve is too short for its head.
        """
        if cut.sleeve is Sleeve.NONE:
            return []
        panels = []
        drawn = SLEEVES[cut.sleeve]
        if self.head is SleeveHead.DROPPED:
            drawn = replace(drawn, length=drawn.length - DROPPED_SHOULDER_REACH)
        ends = [SleeveEnd(self.tip, drawn, side, cut.cuff) for side in FACES]
        caps: list[tuple[Stroke, ...]] = [reverse_strokes(Outline(self.underarm, armhole)) for armhole in self.armholes]
        if self.head is SleeveHead.SET_IN:
            front, back = (labelled_length(Outline(self.underarm, armhole), "scye") for armhole in self.armholes)
            set_in = set_in_caps(ends[0], (front, back))
            caps = [_label_cap(cap, armhole, self) for cap, armhole in zip(set_in, caps, strict=True)]
        for face, end in enumerate(ends):
            if self.head is SleeveHead.RAGLAN:
                neck, line = self._raglan(face)
                upper = (neck[0], *reverse_strokes(Outline(self.underarm, (line,))))
                panels += raglan_sleeves(end, self.neck, upper, height)
            elif cut.sleeve_pieces is SleevePieces.TWO:
                panels += two_piece_sleeves(end, caps[face], height)
            else:
                panels += half_sleeves(end, caps[face], height)
        return panels

    def _raglan(self, face: int) -> tuple[tuple[Stroke, ...], Stroke]:
        """Return the neckline, cut where the raglan line meets it, and that line from the underarm point."""
        first, *others = self.necklines[face]
        neck = cut_stroke(self.neck, first, RAGLAN_SHARE[face], ("", ""))
        (x, y), (u, v) = neck[0].end, self.underarm
        handles = ((u - 0.05, v + 0.03), (x + 0.35 * (u - x), y + 0.30 * (v - y)))
        return (*neck, *others), Stroke(neck[0].end, handles, f"scye.{FACES[face]}.left", notch=0.45)


def _label_cap(cap: Stroke, armhole: tuple[Stroke, ...], shoulder: Shoulder) -> tuple[Stroke, ...]:
    """Return a set-in cap divided as its armhole, with the armhole's labels and notches."""
    if len(armhole) == 1:
        return (replace(cap, label=armhole[0].label, notch=armhole[0].notch),)
    upper = labelled_length(Outline(shoulder.tip, armhole), armhole[0].label)
    whole = labelled_length(Outline(shoulder.tip, armhole), "scye")
    return cut_stroke(shoulder.tip, cap, upper / whole, (armhole[0].label, armhole[1].label))


def draw_shoulder(cut: Cut, m: BodyMeasures) -> Shoulder:
    """Draw the upper ends of a bodice.

    With sleeves: bust + 10 cm (boxy: a regular T-shirt's) or + 8 cm (the arms move), armhole 7 or 6 cm below the
    armpit, 1 cm of shoulder drop, neck 2 cm wider than the body's at each side. Set in: the shoulder ends at its bone,
    and the armhole 3.5 cm below the armpit. Without: bust + 4 cm (skimming, as ribbed tanks are close), + 5 cm, or + 6
    cm where the trunk bends in legs of one piece with it; armhole 3 cm below the armpit; a skimming bodice has straps
    of 5.5 cm, a halter, as close, of `HALTER_STRAP` beside the neck (H. Joseph-Armstrong, halter). The front's armhole
    is hollowed 8 mm more than the back's. Dropped (W. Aldrich, easy-fitting blocks): bust + 16 cm, the shoulder 5 cm
    longer and as steep as the sleeve below it, the armhole 10 cm below the armpit, half as hollow and nearly straight.

    Raises:
        PartsConflict: where a sleeve's head, a yoke or a collar lacks what it is sewn to.
    """
    sleeved, set_in = cut.sleeve is not Sleeve.NONE, cut.sleeve_head is SleeveHead.SET_IN
    if not sleeved and cut.sleeve_head is not SleeveHead.FLAT:
        raise PartsConflict("a sleeve's head needs a sleeve; choose one, or sleeve_head=flat.")
    dropped = cut.sleeve_head is SleeveHead.DROPPED
    if dropped and (cut.bodice is not Bodice.BOXY or cut.sleeve is Sleeve.CAP):
        raise PartsConflict(
            "a dropped shoulder is a boxy bodice's, and covers what a cap sleeve does; choose bodice=boxy and "
            "sleeve=short, elbow or long."
        )
    if sleeved:
        neck, tip = (m.neck_half_width + 0.02, 0.0), (m.shoulder_half_width + 0.01, -0.04)
        ease, drop = (0.10, 0.07) if cut.bodice is Bodice.BOXY else (0.08, 0.06)
        hollows, rise = (0.050, 0.042), (0.012, 0.08)
        if set_in:
            tip, drop, hollows = (m.shoulder_half_width, -0.037), 0.035, (0.060, 0.052)
        if dropped:
            tip = SleeveEnd(tip, SLEEVES[cut.sleeve]).at(DROPPED_SHOULDER_REACH, 0.0)
            ease, drop, hollows, rise = 0.16, 0.10, (0.025, 0.021), (0.006, 0.08)
    else:
        neck = (m.neck_half_width + 0.025, -0.005)
        tips = {Bodice.SKIMMING: (neck[0] + 0.052, -0.023), Bodice.HALTER: (neck[0] + HALTER_STRAP, -0.017)}
        tip = tips.get(cut.bodice, (m.shoulder_half_width - 0.02, -0.034))
        ease = {Bodice.BOXY: 0.10, Bodice.SHIFT: 0.05}.get(cut.bodice, 0.04)
        ease, drop = ease if cut.legs is Legs.NONE else 0.06, 0.03
        hollows, rise = (0.058, 0.050), (0.016, 0.09)
    under = ((m.bust + ease) / 4, m.armpit_height - drop - m.nape_height)
    throats = (
        NecklineCut.at_front(cut.neckline, cut.neck_depth),
        NecklineCut.at_back(cut.back_neckline, cut.back_depth),
    )
    neck = side_neck((cut.neckline, cut.back_neckline), neck, tip)
    armholes: list[tuple[Stroke, ...]] = []
    for side, hollow in zip(FACES, hollows, strict=True):
        scye = ((under[0] - hollow, under[1] + 0.004), (tip[0] - rise[0], tip[1] - rise[1]))
        if cut.bodice is Bodice.HALTER:
            scye = _halter_armhole_handles(under, tip)
        if sleeved:
            armholes.append((Stroke(tip, scye, label=f"scye.{side}.left", notch=0.45),))
        else:
            armholes.append((Stroke(tip, scye, contour="armhole.left"),))
    if cut.sleeve_pieces is SleevePieces.TWO:
        armholes = [
            cut_stroke(under, whole[0], UNDER_SHARE, (f"scye.{side}.under.left", f"scye.{side}.left"))
            for side, whole in zip(FACES, armholes, strict=True)
        ]
    necklines = [tuple(draw_neckline(throat, neck)) for throat in throats]
    for face in cut.yoke.faces:
        divided = FACES.index(face)
        armholes[divided] = divide_armhole(cut, face, under, armholes[divided][0], necklines[divided])
    if cut.collar is not Collar.NONE:
        necklines = [sew_collar(cut, face, line) for face, line in zip(FACES, necklines, strict=True)]
    if cut.collar in LAPELLED_COLLARS:
        necklines[0] = sew_lapel(neck, necklines[0])
    if cut.hood is not Hood.NONE:
        necklines = [sew_hood(cut, face, neck, line) for face, line in zip(FACES, necklines, strict=True)]
    return Shoulder(neck, tip, under, (armholes[0], armholes[1]), (necklines[0], necklines[1]), cut.sleeve_head)


def _halter_armhole_handles(underarm: Point, tip: Point) -> tuple[Point, Point]:
    """Return the handles of a halter's armhole, which reaches the neck and is hollowed by a tenth of its length."""
    (u, v), (x, y) = underarm, tip
    return (u - 0.40 * (u - x), v + 0.15 * (y - v)), (x + 0.15 * (u - x), y - 0.40 * (y - v))


def draw_top(cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw front, back, yoke, collar and sleeves of a top, or of a dress in one piece.

    Raises:
        PartsConflict: where the bodice cannot have its shaping or its yoke.
    """
    if cut.bodice is Bodice.STRAPLESS:
        return _draw_strapless(cut, m)
    shoulder = draw_shoulder(cut, m)
    line = Waistline.of(cut, shoulder.underarm[0], half_waist(cut, m) / 2)
    side = _side_seam(cut, m, shoulder.underarm, line)
    if cut.shaping is not Shaping.NONE:
        _check_shaping(cut)
    if cut.front is Front.WRAP:
        side = divide_side(side, m.waist_height - m.nape_height)
    panels = []
    for face, name in enumerate(FACES):
        upper, apex = shoulder.strokes(face), shoulder.underarm[1] - APEX_BELOW[face]
        if name in cut.yoke.faces:
            upper, pieces = cut_yoke(name, upper)
            panels += [place_panel(part, outline, m.nape_height) for part, outline in pieces]
        if cut.front is Front.WRAP and name == "front":
            waist = line.strokes(name, side[0].end[1], apex) if cut.waist is Waist.SEAM else ()
            outlines = draw_wrap(side, upper[: -len(shoulder.necklines[face])], waist)
        elif cut.shaping is Shaping.PRINCESS:
            outlines = draw_princess(name, line, side, upper, apex, cut.waist is Waist.SEAM)
        else:
            outlines = [(name, _draw_single_panel(cut, name, line, side, upper, apex))]
        outlines = [piece for part, outline in outlines for piece in _cut_centre(cut, part, outline)]
        panels += [
            place_panel(part, outline, m.nape_height, label=_label(cut, part), across=_inward_shift(part))
            for part, outline in outlines
        ]
    panels += shoulder.collar(cut, m)
    sleeves = shoulder.sleeves(cut, m.nape_height)
    if not sleeves:
        return panels
    return sorted([*panels, *sleeves], key=lambda panel: (panel.name not in FACES, panel.name))


def _label(cut: Cut, part: str) -> str:
    """Return the label of a panel of the trunk: the front that is wrapped over the other has its own."""
    return WRAP_LABEL if cut.front is Front.WRAP and part == "front_right" else "body"


def _cut_centre(cut: Cut, part: str, outline: Outline) -> list[tuple[str, Outline]]:
    """Return a panel, cut at the centre where it lies across it and the garment opens there."""
    if part == "back" and cut.waist is Waist.NONE:
        return cut_back(cut, part, outline)
    return cut_front(cut, part, outline) if part == "front" else [(part, outline)]


def _draw_single_panel(
    cut: Cut, face: str, line: Waistline, side: list[Stroke], upper: list[Stroke], apex: float
) -> Outline:
    """Draw a front or back in one piece, with its darts if any."""
    if cut.waist is Waist.SEAM:
        waist = line.strokes(face, side[0].end[1], apex)
        return unfold_closed(Outline((0.0, side[0].end[1]), (*waist, *side[1:], *upper)))
    return unfold(Outline(side[0].end, (*side[1:], *upper)), "hem")


def _draw_strapless(cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw front and back of a bodice that ends in a level line below the arms (H. Joseph-Armstrong, strapless). Its
    upper edge has the length of the body's girth there, bust without ease, 3 cm below the armpit, and so holds it."""
    under = (m.bust / 4, m.armpit_height - STRAPLESS_DROP - m.nape_height)
    line = Waistline.of(cut, under[0], half_waist(cut, m) / 2)
    side, upper = _side_seam(cut, m, under, line), [Stroke((0.0, under[1]), contour="neck")]
    if cut.shaping is not Shaping.NONE:
        _check_shaping(cut)
    if cut.shaping is Shaping.PRINCESS:
        raise PartsConflict("a princess seam begins at the shoulder seam; choose another bodice or shaping=darts.")
    whole = [
        (name, _draw_single_panel(cut, name, line, side, upper, under[1] - APEX_BELOW[face]))
        for face, name in enumerate(FACES)
    ]
    pieces = [piece for name, outline in whole for piece in _cut_centre(cut, name, outline)]
    return [place_panel(part, outline, m.nape_height) for part, outline in pieces]


def _inward_shift(part: str) -> float:
    """Return the shift of a side panel towards the middle [m]: outside the shoulders only sleeves are expected."""
    return 0.0 if "_side_" not in part else -PLACED_INWARD if part.endswith("left") else PLACED_INWARD


def _check_shaping(cut: Cut) -> None:
    """Check that darts have a waist seam to begin at, and shaping a waist that is not straight."""
    if cut.bodice is Bodice.BOXY and cut.is_shaped_by_seams:
        raise PartsConflict("a boxy bodice falls straight; choose bodice=shift to shape it.")
    if cut.shaping is Shaping.DARTS and cut.waist is Waist.NONE:
        raise PartsConflict("a bodice's darts begin at a waist seam; add waist=seam, or choose shaping=princess.")


def _side_seam(cut: Cut, m: BodyMeasures, underarm: Point, line: Waistline) -> list[Stroke]:
    """Draw the side seam from the hem, the end of the first stroke, to the underarm point. A boxy top is straight to 2
    cm below the hip line. A skimming one ends 5 cm above it (waist + 12 cm, hip + 2 cm, no darts). A dress without a
    zip has waist + 10 cm and hip + 8 cm, 2 cm more of each with sleeves, and reaches the knee; an A-line one is flared
    to 1.36 m for a free step. With a waist seam it ends at the natural waist, gathered `BLOUSON_OVERHANG` below it.
    Princess seams take in the waist and widen the hem; the side seam is moved out by as much. A top with a rib
    around its hem is as long with it."""
    sleeved, rib = cut.sleeve is not Sleeve.NONE, HEM_RIB_WIDTH if cut.hem_band is HemBand.RIB else 0.0
    if cut.waist is Waist.SEAM:
        longer = BLOUSON_OVERHANG if cut.shaping is Shaping.GATHERS else 0.0
        corner = (line.half, m.waist_height - longer - m.nape_height)
        return [Stroke(corner), Stroke(underarm, label="side.left", notch=0.5)]
    if cut.bodice is Bodice.BOXY and cut.skirt is Skirt.NONE:
        hem = (underarm[0], m.hip_height - 0.02 + rib - m.nape_height)
        return [Stroke(hem), Stroke(underarm, label="side.left", notch=0.5)]
    ease = (0.12, 0.10) if sleeved else (0.10, 0.08)
    hip, waist = (m.hip + ease[1]) / 4, (m.waist + ease[0]) / 4
    if cut.bodice is Bodice.BOXY:
        hip = waist = max(hip, underarm[0])
    knee = m.crotch_height - 0.29
    widths = {Skirt.A_LINE: 0.34, Skirt.STRAIGHT: hip, Skirt.PENCIL: hip - 0.015}
    if cut.skirt is Skirt.NONE and cut.bodice in (Bodice.SKIMMING, Bodice.HALTER, Bodice.STRAPLESS):
        sides = [((m.hip + 0.02) / 4, m.hip_height + 0.05 + rib), ((m.waist + 0.12) / 4, m.waist_height)]
    elif cut.skirt is Skirt.NONE:
        sides = [(hip, m.hip_height + rib), (waist, m.waist_height)]
    elif cut.skirt in widths:
        sides = [(widths[cut.skirt], knee), (hip, m.hip_height), (waist, m.waist_height)]
    else:
        raise PartsConflict(f"a {cut.skirt} skirt is not cut in one with a bodice; add waist=seam.")
    if cut.shaping is Shaping.PRINCESS:
        sides[-1] = (line.half, m.waist_height)
        if len(sides) > 2:
            sides[0] = (sides[0][0] - PRINCESS_SEAM_FLARE / 2, sides[0][1])
    points = [*((x, y - m.nape_height) for x, y in sides), underarm]
    return [Stroke(points[0]), *draw_monotone_spline(points, [f"side.{i}.left" for i in range(len(points) - 1)])]
