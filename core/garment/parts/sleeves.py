"""Draft sleeves in halves in the plane of front and back; both are cut as one piece, folded along the arm.

A flat sleeve is the front or back of a T-shirt's laid beside the bodice, its cap the armhole's own curve (the flat
block of W. Aldrich, Metric Pattern Cutting for Women's Wear, for jersey and easy-fitting garments); below a dropped
shoulder it is shorter by what the shoulder reaches over the arm. A set-in sleeve has
a cap of its own, a third of the armhole high and eased into it (her one-piece sleeve block). A raglan sleeve reaches
the neck: the bodice ends at a line from the neckline to the underarm, and the part above belongs to the sleeve. A
sleeve of two pieces (her two-piece sleeve block) has a top and an under sleeve, with a forearm and a hindarm seam.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..outline import PLACKET_CONTOUR, Outline, Point, Stroke, labelled_length, mirror, place_panel, to_point
from ..pattern import Panel
from .cut import Cuff, PartsConflict, Sleeve
from .ribs import RIB_RATIO

CAP_HEIGHT = 1.0 / 3.0
"""Height of a set-in cap as a share of the length of its armhole."""

CAP_EASE = 0.04
"""Share by which a set-in cap is longer than its armhole: 2 cm of a shirt's or dress's 45, less than a jacket's 3."""

SLEEVE_CUFF_WIDTH = 0.06
"""Width of a cuff [m]: that of a shirt."""

CUFF_FULLNESS = 1.25
"""Ratio of the width of a sleeve to that of the cuff it is gathered into: 6 cm of pleats in a shirt's."""

SLEEVE_SLIT_LENGTH = 0.11
"""Length of the slit of a sleeve above a shirt's cuff [m]: 10 to 12 cm, so that the hand passes (W. Aldrich, shirt
sleeve with a cuff)."""

CUFF_CLOSURE = "buttons"
"""Word of the label of the ends of a cuff that are buttoned."""

BOUND_SLIT_WIDTH = 0.012
"""Width at the cuff that the seam of a binding takes from both edges of a slit [m]: 6 mm each, tapering to nothing at
its upper end (H. Joseph-Armstrong, Patternmaking for Fashion Design, continuous bound placket)."""

UNDER_CUFF = 0.45
"""Share of half a cuff that belongs to the under sleeve of a sleeve of two pieces: it is the narrower one."""

ELBOW_BOW = 0.008
"""Depth by which each side of the forearm seam is hollowed, and of the hindarm seam rounded, at the middle [m]: the
sleeve then follows an arm that hangs slightly bent, as the two-piece block's elbow line does."""

FULL_CAP = 0.6
"""Ratio of the handles of a set-in cap to its half width: the cap then rises bell-shaped over the shoulder's end."""


@dataclass(frozen=True)
class SleeveCut:
    """Describe the cut of a sleeve: the angle of its upper edge below the horizontal in the draft [rad], its length
    along that edge from the shoulder's tip [m], half the cuff's circumference [m], and the width of a rib at its end
    [m]."""

    droop: float
    length: float
    cuff_half: float
    rib_width: float = 0.025


SLEEVES = {
    Sleeve.CAP: SleeveCut(np.deg2rad(8.0), 0.115, 0.17),
    Sleeve.SHORT: SleeveCut(np.deg2rad(12.0), 0.19, 0.175),
    Sleeve.ELBOW: SleeveCut(np.deg2rad(10.0), 0.25, 0.155),
    Sleeve.LONG: SleeveCut(np.deg2rad(4.0), 0.46, 0.11, 0.06),
}
"""Cut of each sleeve. A cap covers the shoulder's end and closes just below the arm. A short one is a T-shirt's: 19 cm
along the top and a cuff of 35 cm, 8 cm of ease; 12 degrees are between an arm stretched out (0) and one hanging (about
60), nearer to the T-pose. To the elbow: a dress's, whose cuff of 31 cm still passes the bent elbow. Long: to the wrist
bone; with more droop it would start its drape beside the stretched-out arm instead of around it; its cuff of 22 cm
passes the hand. A rib is 6 cm wide at the wrist, as a sweatshirt's, and 2.5 cm above the elbow, as a polo shirt's."""


@dataclass(frozen=True)
class SleeveEnd:
    """Describe the part of a sleeve below its cap, in the plane of its half: along the arm from the cap's top, and
    across it.

    Attributes:
        top: Position of the cap's top [m].
        side: `front` or `back`.
        cuff: The cuff of its own that the sleeve ends in, if any.
    """

    top: Point
    cut: SleeveCut
    side: str = ""
    cuff: Cuff = Cuff.NONE

    @property
    def banded(self) -> bool:
        """Return whether the sleeve ends in a cuff of its own."""
        return self.cuff is not Cuff.NONE

    @property
    def cuff_width(self) -> float:
        """Return the width of the sleeve's own cuff [m]; 0 where it has none."""
        widths = {Cuff.BAND: SLEEVE_CUFF_WIDTH, Cuff.SHIRT: SLEEVE_CUFF_WIDTH, Cuff.RIB: self.cut.rib_width}
        return widths.get(self.cuff, 0.0)

    @property
    def half_widths(self) -> tuple[float, float]:
        """Return half the girth of the sleeve at the seam of its cuff, and of the cuff [m]: a band has the girth of a
        sleeve without a cuff, and the sleeve is wider; a rib is narrower than such a sleeve."""
        own = self.cut.cuff_half
        return (own, RIB_RATIO * own) if self.cuff is Cuff.RIB else (CUFF_FULLNESS * own, own)

    @property
    def has_slit(self) -> bool:
        """Return whether this half of the sleeve has the slit above a shirt's cuff: behind, in line with the elbow."""
        return self.cuff is Cuff.SHIRT and self.side == "back"

    def at(self, along: float, across: float) -> Point:
        """Return the point `along` the arm from the cap's top and `across` it downwards [m]."""
        c, s = float(np.cos(self.cut.droop)), float(np.sin(self.cut.droop))
        return (self.top[0] + along * c - across * s, self.top[1] - along * s - across * c)

    def strokes(self) -> tuple[Stroke, ...]:
        """Return the strokes from the underarm along the lower seam to the sleeve's end, and along that to the fold,
        around a slit halfway between them."""
        if not self.banded:
            low, top = self.at(self.cut.length, self.cut.cuff_half), self.at(self.cut.length, 0.0)
            return Stroke(low, label="undersleeve.left"), Stroke(top, contour="cuff.left")
        end = self.cut.length - self.cuff_width
        low, top = self.at(end, self.half_widths[0]), self.at(end, 0.0)
        lower, seam = Stroke(low, label="undersleeve.left"), Stroke(top, label=f"cuffseam.{self.side}.left")
        if not self.has_slit:
            return lower, seam
        middle, open_half, slit = 0.5 * self.half_widths[0], 0.5 * BOUND_SLIT_WIDTH, f"{PLACKET_CONTOUR}.left"
        return (
            lower,
            Stroke(self.at(end, middle + open_half), label=f"cuffseam.{self.side}.under.left"),
            Stroke(self.at(end - SLEEVE_SLIT_LENGTH, middle), contour=slit),
            Stroke(self.at(end, middle - open_half), contour=slit),
            seam,
        )

    def place(self, outline: Outline, height: float, name: str = "sleeve") -> list[Panel]:
        """Place the left half sleeve, its mirror image, and the halves of both cuffs."""
        panels = self._place(name, outline, height)
        if self.banded:
            wide, name = self.half_widths[1], "cuff_rib" if self.cuff is Cuff.RIB else "cuff"
            over, under, seam = "cuffover.left", "cuffunder.left", f"cuffseam.{self.side}"
            if self.has_slit:
                closed = f"cuff.{CUFF_CLOSURE}.left"
                panels += self._place(
                    "cuff", self._draw_cuff((0.0, 0.5 * wide), (over, f"{seam}.left", closed)), height
                )
                part = self._draw_cuff((0.5 * wide, wide), (closed, f"{seam}.under.left", under))
                panels += self._place("cuff_under", part, height)
            else:
                panels += self._place(name, self._draw_cuff((0.0, wide), (over, f"{seam}.left", under)), height)
        return panels

    def _draw_cuff(self, across: tuple[float, float], labels: tuple[str, str, str]) -> Outline:
        """Draw a part of a cuff between two distances from the fold [m]; its labels at the first one, at the sleeve and
        at the last one."""
        (first, last), (over, seam, under) = across, labels
        end = self.cut.length - self.cuff_width
        start = self.at(end, first)
        strokes = (
            Stroke(self.at(end, last), label=seam),
            Stroke(self.at(self.cut.length, last), label=under),
            Stroke(self.at(self.cut.length, first), contour="cuff.left"),
            Stroke(start, label=over),
        )
        return Outline(start, strokes)

    def _place(self, name: str, outline: Outline, height: float) -> list[Panel]:
        # The warp runs along the arm; a grainline is a line, so its angle is given within a quarter turn of +y.
        grain = (np.pi / 2 - self.cut.droop) * (1.0 if self.side == "front" else -1.0)
        left = place_panel(f"{name}_{self.side}_left", outline, height, grain, "sleeve")
        right = place_panel(f"{name}_{self.side}_right", mirror(outline), height, -grain, "sleeve")
        return [left, right]


def half_sleeves(end: SleeveEnd, cap: tuple[Stroke, ...], height: float) -> list[Panel]:
    """Draw the left half sleeve of one side in the body's plane and mirror it.

    Args:
        end: The part below the cap.
        cap: From its top at the shoulder to the underarm.
        height: Of the draft's origin [m].
    """
    return end.place(Outline(end.top, (*cap, *end.strokes(), Stroke(end.top, label="oversleeve.left"))), height)


def two_piece_sleeves(end: SleeveEnd, cap: tuple[Stroke, ...], height: float) -> list[Panel]:
    """Draw the left halves of a top and an under sleeve and mirror them. Both sides of the seam between them mirror
    each other at its chord, so that they are equal in length.

    Args:
        end: The part below the cap.
        cap: From its top at the shoulder to the seam, and on to the underarm.
        height: Of the draft's origin [m].
    """
    over, under = cap
    lower, cuff = end.strokes()
    wrist = end.at(end.cut.length, (1.0 - UNDER_CUFF) * end.cut.cuff_half)
    label = f"{'forearm' if end.side == 'front' else 'hindarm'}.left"
    hollow = ELBOW_BOW if end.side == "front" else -ELBOW_BOW
    top = (
        over,
        Stroke(wrist, _bow(over.end, wrist, hollow), label=label),
        cuff,
        Stroke(end.top, label="oversleeve.left"),
    )
    below = (
        under,
        lower,
        Stroke(wrist, contour="cuff.left"),
        Stroke(over.end, _bow(wrist, over.end, hollow), label=label),
    )
    return [
        *end.place(Outline(end.top, top), height),
        *end.place(Outline(over.end, below), height, "undersleeve"),
    ]


def _bow(start: Point, end: Point, left: float) -> tuple[Point, Point]:
    """Return the handles of a cubic whose middle is `left` [m] to the left of its chord."""
    chord = np.subtract(end, start)
    across = np.array([-chord[1], chord[0]]) / np.linalg.norm(chord) * left * 4.0 / 3.0
    return to_point(start + chord / 3.0 + across), to_point(start + 2.0 * chord / 3.0 + across)


def raglan_sleeves(end: SleeveEnd, neck: Point, upper: tuple[Stroke, ...], height: float) -> list[Panel]:
    """Draw the left half of a raglan sleeve and mirror it.

    Args:
        end: The part below the shoulder's tip, where the shoulder seam continues along the arm.
        neck: The side neck point [m].
        upper: From there along the neckline and down the raglan line to the underarm.
        height: Of the draft's origin [m].
    """
    over = (Stroke(end.top, label="oversleeve.left"), Stroke(neck, label="shoulder.left"))
    return end.place(Outline(neck, (*upper, *end.strokes(), *over)), height)


def set_in_caps(end: SleeveEnd, armholes: tuple[float, float]) -> tuple[Stroke, Stroke]:
    """Draw the caps of a set-in sleeve's front and back half, from the top to the underarm. Each is one S-shaped cubic:
    level at the top, and at a right angle to the lower seam at its end. Both have the same height and width, so that
    the lower seams are equal; the width is solved for the longer half's length, and the other's handles are shortened
    until it has its own.

    Args:
        end: The part below the cap.
        armholes: Lengths of the armhole's front and back [m].

    Raises:
        PartsConflict: where the sleeve ends within its cap.
    """
    from scipy.optimize import brentq  # a slow import, not needed to read templates

    high = CAP_HEIGHT * sum(armholes)
    if end.cut.length - end.cuff_width < high + 0.02:
        raise PartsConflict("this sleeve ends above the underarm, within a set-in cap; choose sleeve_head=flat.")

    def cap(wide: float, bow: float) -> Stroke:
        return Stroke(end.at(high, wide), (end.at(0.0, bow * wide), end.at(high, (1.0 - bow) * wide)), label="cap")

    def excess(stroke: Stroke, armhole: float) -> float:
        return labelled_length(Outline(end.top, (stroke,)), "cap") - (1.0 + CAP_EASE) * armhole

    full = max(armholes)
    wide = brentq(lambda w: excess(cap(w, FULL_CAP), full), 0.02, 2 * full, xtol=1e-12)
    bows = [
        FULL_CAP if own == full else brentq(lambda b, own=own: excess(cap(wide, b), own), 0.05, FULL_CAP)
        for own in armholes
    ]
    return cap(wide, bows[0]), cap(wide, bows[1])
