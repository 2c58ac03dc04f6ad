"""Draft bodices: front and back from the shoulder to a hem at the hips or, cut in one with a skirt, at the knee.

All are blocks for planar placement: front and back stand before and behind the body, and half sleeves continue them in
the same plane, so that a flattened body in T-pose fits between.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..measures import BodyMeasures
from ..outline import Outline, Point, Stroke, place_panel, smooth, unfold, unfold_closed
from ..pattern import Panel
from .cut import Bodice, Cut, Legs, PartsConflict, Skirt, Sleeve, Waist
from .necklines import Throat, draw_neckline, side_neck
from .skirts import half_waist
from .sleeves import SLEEVES, half_sleeves

FACES = ("front", "back")


@dataclass(frozen=True)
class Shoulder:
    """Describe the upper ends of a bodice's front and back.

    Attributes:
        neck: Side neck point [m].
        tip: Shoulder's tip [m].
        under: Underarm point, where the side seam ends [m].
        armholes: From the underarm point to the shoulder's tip, of the front and of the back.
        throats: Their necklines.
    """

    neck: Point
    tip: Point
    under: Point
    armholes: tuple[Stroke, Stroke]
    throats: tuple[Throat, Throat]

    def strokes(self, face: int) -> list[Stroke]:
        """Return armhole, shoulder seam and neckline of the front (0) or the back (1), from the side to the middle."""
        neckline = draw_neckline(self.throats[face], self.neck)
        return [self.armholes[face], Stroke(self.neck, label="shoulder.left"), *neckline]

    def sleeves(self, sleeve: Sleeve, height: float) -> list[Panel]:
        """Return the half sleeves of both arms; none where there is no sleeve."""
        if sleeve is Sleeve.NONE:
            return []
        panels = []
        for side, armhole in zip(FACES, self.armholes, strict=True):
            panels += half_sleeves(side, self.under, self.tip, armhole.handles, height, SLEEVES[sleeve])
        return panels


def draw_shoulder(cut: Cut, m: BodyMeasures) -> Shoulder:
    """Draw the upper ends of a bodice.

    With sleeves: bust + 10 cm (boxy: a regular T-shirt's) or + 8 cm (the arms move), armhole 7 or 6 cm below the
    armpit, 1 cm of shoulder drop, neck 2 cm wider than the body's at each side. Without: bust + 4 cm (skimming, as
    ribbed tanks are close), + 5 cm, or + 6 cm where the trunk bends in legs of one piece with it; armhole 3 cm below
    the armpit; a skimming bodice hangs by straps of 5.5 cm. The front's armhole is hollowed 8 mm more than the back's.
    """
    sleeved = cut.sleeve is not Sleeve.NONE
    if sleeved:
        neck, tip = (m.neck_half_width + 0.02, 0.0), (m.shoulder_half_width + 0.01, -0.04)
        ease, drop = (0.10, 0.07) if cut.bodice is Bodice.BOXY else (0.08, 0.06)
        hollows, rise = (0.050, 0.042), (0.012, 0.08)
    else:
        neck = (m.neck_half_width + 0.025, -0.005)
        strapped = cut.bodice is Bodice.SKIMMING
        tip = (neck[0] + 0.052, -0.023) if strapped else (m.shoulder_half_width - 0.02, -0.034)
        ease = {Bodice.BOXY: 0.10, Bodice.SHIFT: 0.05, Bodice.SKIMMING: 0.04}[cut.bodice]
        ease, drop = ease if cut.legs is Legs.NONE else 0.06, 0.03
        hollows, rise = (0.058, 0.050), (0.016, 0.09)
    under = ((m.bust + ease) / 4, m.armpit_height - drop - m.nape_height)
    throats = (
        Throat.at_front(cut.neckline, cut.neck_depth),
        Throat.at_back(cut.back_neckline, cut.back_depth),
    )
    neck = side_neck((cut.neckline, cut.back_neckline), neck, tip)
    armholes = []
    for side, hollow in zip(FACES, hollows, strict=True):
        scye = ((under[0] - hollow, under[1] + 0.004), (tip[0] - rise[0], tip[1] - rise[1]))
        if sleeved:
            armholes.append(Stroke(tip, scye, label=f"scye.{side}.left", notch=0.45))
        else:
            armholes.append(Stroke(tip, scye, contour="armhole.left"))
    return Shoulder(neck, tip, under, (armholes[0], armholes[1]), throats)


def draw_top(cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw front, back and sleeves of a top, or of a dress in one piece."""
    shoulder = draw_shoulder(cut, m)
    side = _side_seam(cut, m, shoulder.under)
    panels = []
    for face, name in enumerate(FACES):
        strokes = (*side[1:], *shoulder.strokes(face))
        if cut.waist is Waist.SEAM:
            middle = (0.0, side[0].end[1])
            waist = Stroke(side[0].end, label=f"waist.{name}.left")
            outline = unfold_closed(Outline(middle, (waist, *strokes)))
        else:
            outline = unfold(Outline(side[0].end, strokes), "hem")
        panels.append(place_panel(name, outline, m.nape_height))
    sleeves = shoulder.sleeves(cut.sleeve, m.nape_height)
    if not sleeves:
        return panels
    return sorted([*panels, *sleeves], key=lambda panel: (panel.name not in FACES, panel.name))


def _side_seam(cut: Cut, m: BodyMeasures, under: Point) -> list[Stroke]:
    """Draw the side seam from the hem to the underarm point; the first stroke only ends where it begins.

    A boxy top falls straight to 2 cm below the hip line. A skimming one ends 5 cm above it (waist + 12 cm, hip + 2 cm,
    no darts). A dress that goes on without a zip has waist + 10 cm and hip + 8 cm, 2 cm more of each with sleeves, and
    goes to the knee; an A-line one is flared to 1.36 m for a free step. With a waist seam it ends at the natural waist.
    """
    sleeved = cut.sleeve is not Sleeve.NONE
    if cut.waist is Waist.SEAM:
        corner = (half_waist(cut, m) / 2, m.waist_height - m.nape_height)
        return [Stroke(corner), Stroke(under, label="side.left", notch=0.5)]
    if cut.bodice is Bodice.BOXY and cut.skirt is Skirt.NONE:
        hem = (under[0], m.hip_height - 0.02 - m.nape_height)
        return [Stroke(hem), Stroke(under, label="side.left", notch=0.5)]
    ease = (0.12, 0.10) if sleeved else (0.10, 0.08)
    hip, waist = (m.hip + ease[1]) / 4, (m.waist + ease[0]) / 4
    if cut.bodice is Bodice.BOXY:
        hip = waist = max(hip, under[0])
    knee = m.crotch_height - 0.29
    widths = {Skirt.A_LINE: 0.34, Skirt.STRAIGHT: hip, Skirt.PENCIL: hip - 0.015}
    if cut.skirt is Skirt.NONE and cut.bodice is Bodice.SKIMMING:
        sides = [((m.hip + 0.02) / 4, m.hip_height + 0.05), ((m.waist + 0.12) / 4, m.waist_height)]
    elif cut.skirt is Skirt.NONE:
        sides = [(hip, m.hip_height), (waist, m.waist_height)]
    elif cut.skirt in widths:
        sides = [(widths[cut.skirt], knee), (hip, m.hip_height), (waist, m.waist_height)]
    else:
        raise PartsConflict(f"a {cut.skirt} skirt is not cut in one with a bodice; add waist=seam.")
    points = [*((x, y - m.nape_height) for x, y in sides), under]
    return [Stroke(points[0]), *smooth(points, [f"side.{i}.left" for i in range(len(points) - 1)])]
