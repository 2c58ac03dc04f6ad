"""Read the number of a skirt's gores, and their flare, from the corners of its hem."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...garment.parts.cut import Bodice, Cut, Gores, Shaping, Skirt
from ...scan.contours.edge_turn import EdgeTurn
from ...scan.contours.target import Target

MIN_GORE_COUNT = 6
"""Number of corners from which a skirt is gored: a skirt of four panels has four, from side and centre seams."""

MIN_GORE_EVENNESS_RATIO = 0.5
"""Smallest ratio of the widths of two gores at the hem, and of two corners, of one skirt: below it the corners have
another cause, such as slits or a torn edge."""


@dataclass(frozen=True)
class HemGores:
    """Describe the gores that a hem shows.

    Attributes:
        gores: Their number.
        sweep: Whole angle of them all laid side by side [rad].
    """

    gores: Gores
    sweep: float

    def is_cut(self, cut: Cut) -> bool:
        """Check whether a cut has as many gores."""
        return cut.skirt is Skirt.GORED and cut.gores is self.gores

    def flare(self, cut: Cut) -> Cut:
        """Return a cut with as many gores flared to the same angle; others, and gores below darts, unchanged."""
        return replace(cut, sweep=self.sweep) if self.is_cut(cut) and cut.shaping is Shaping.NONE else cut

    def describe(self, cut: Cut) -> str:
        """Return a note to the user, whose cut has no gores, with the parts that draft them."""
        angle = np.degrees(self.sweep)
        seam = "" if cut.bodice is Bodice.NONE else ",waist=seam"
        return (
            f"The hem has {self.gores} corners, as between gores that flare by {angle:.0f} degrees in all; "
            f"'--part skirt=gored,gores={self.gores}{seam}' drafts these."
        )


def find_gores(target: Target) -> HemGores | None:
    """Find the gores of a skirt by its hem; None unless each of their seams ends in a corner there.

    A gore is cut straight across at the hem, at a right angle to its middle. Its sides slant, so at each seam the hem
    turns by the angle between two middles, and the whole hem by the sum: 2 pi is a full circle. Folds do not change it
    (`EdgeTurn`). Gores with hems curved to hang level leave no corner.
    """
    hem = next((one for one in target.contours if one.name == "hem" and one.trusted), None)
    if hem is None:
        return None
    edge = EdgeTurn.of_target(hem, target)
    corners = edge.corners()
    if len(corners) < MIN_GORE_COUNT or str(len(corners)) not in list(Gores) or not edge.is_clear(corners):
        return None
    places, turns = np.sort(edge.places[corners]), edge.turn[corners]
    widths = np.diff(np.append(places, places[0] + edge.length))
    if turns.min() < MIN_GORE_EVENNESS_RATIO * turns.max() or widths.min() < MIN_GORE_EVENNESS_RATIO * widths.max():
        return None
    return HemGores(Gores(str(len(corners))), float(turns.sum()))
