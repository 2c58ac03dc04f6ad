"""Cut a bodice at the centre front, for a garment that is closed there or worn open (W. Aldrich, Metric Pattern Cutting
for Women's Wear). A placket is a slit from the neck, sewn up below. The draft ends at the centre front line, where the
edges of a zip meet. Of a buttoned front each side is cut wider by a button stand, which lies on the other one: it is
added to the cut pieces, since both are one surface when it is closed."""

from __future__ import annotations

from dataclasses import replace

from ..outline import Outline, Stroke, halve, mirror
from .cut import Bodice, Cut, Front, Legs, PartsConflict, Skirt, Waist

FRONT_CONTOUR = "front.left"
"""Open contour of the left edge of a front that is worn open."""


PLACKET_LENGTH = 0.16
"""Length of a placket below the neckline [m]: three buttons 6 cm apart, the first 2 cm below the neck (H.
Joseph-Armstrong, Patternmaking for Fashion Design, plackets); a head then passes a neckline of a neck's girth."""


def check_front(cut: Cut) -> None:
    """Check that a cut has a bodice that can be opened in front.

    Raises:
        PartsConflict: where it has none, or what crosses its centre front could not be opened.
    """
    if cut.front is Front.NONE:
        return
    if cut.bodice in (Bodice.NONE, Bodice.HALTER, Bodice.STRAPLESS):
        raise PartsConflict("a front is opened from the neck down; choose bodice=boxy, shift or skimming.")
    if "front" in cut.yoke.faces:
        raise PartsConflict("a yoke in front is not drafted across an opening; choose yoke=back, or front=none.")
    if cut.legs is not Legs.NONE:
        raise PartsConflict("a suit's front is sewn at the centre already; choose front=none.")
    if cut.front is Front.OPEN and cut.skirt is not Skirt.NONE and cut.waist is Waist.SEAM:
        raise PartsConflict("an open front ends at the hem of one piece; choose waist=none, or front=zip or buttons.")


def cut_front(cut: Cut, name: str, outline: Outline) -> list[tuple[str, Outline]]:
    """Return a piece that lies across the centre front as it is cut: in one, or a left and a right half.

    Args:
        cut: The garment's.
        name: The piece's.
        outline: Symmetric about the centre.
    """
    if cut.front in (Front.NONE, Front.WRAP):
        return [(name, outline)]
    seam = Stroke((0.0, 0.0), contour=FRONT_CONTOUR)
    if cut.front is not Front.OPEN:
        seam = Stroke((0.0, 0.0), label=f"front.{cut.front}.{name}")
    left = halve(outline, seam)
    if cut.front is Front.PLACKET:
        left = _slit(left, seam.label)
    return [(f"{name}_left", left), (f"{name}_right", mirror(left))]


def _slit(left: Outline, label: str) -> Outline:
    """Return a left half whose edge in the middle is open from the neck for the length of a placket: all of it where it
    is no longer, as a collar's."""
    middle = next(i for i, stroke in enumerate(left.strokes) if stroke.label == label)
    stroke, top = left.strokes[middle], left.strokes[middle - 1].end
    end = top[1] - PLACKET_LENGTH
    parts: tuple[Stroke, ...] = (Stroke((0.0, end), contour="neck"), stroke)
    if end <= stroke.end[1]:
        parts = (replace(stroke, label="", contour="neck"),)
    return replace(left, strokes=(*left.strokes[:middle], *parts, *left.strokes[middle + 1 :]))
