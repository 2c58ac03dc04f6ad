"""Read the number of a skirt's gores, and how far they flare, from the corners of its hem."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...garment.parts.cut import Bodice, Cut, Gores, Shaping, Skirt
from ...scan.contours.edge_turn import EdgeTurn
from ...scan.contours.target import Target

MIN_GORE_COUNT = 6
"""Number of corners from which a skirt is gored: four are where side and centre seams of a skirt of four panels end."""

MIN_GORE_EVENNESS_RATIO = 0.5
"""Smallest ratio of the widths of two gores at the hem, and of two corners, of one skirt: below it something else made
them, as slits or a torn edge do."""


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
        """Return a cut with as many gores with them flared alike; others, and gores below darts, as they are."""
        return replace(cut, sweep=self.sweep) if self.is_cut(cut) and cut.shaping is Shaping.NONE else cut

    def describe(self, cut: Cut) -> str:
        """Return one sentence for the user, who is given a cut without them, with the parts that draft them."""
        angle = np.degrees(self.sweep)
        seam = "" if cut.bodice is Bodice.NONE else ",waist=seam"
        return (
            f"The hem has {self.gores} corners, as between gores that flare by {angle:.0f} degrees in all; "
            f"'--part skirt=gored,gores={self.gores}{seam}' drafts these."
        )


def find_gores(target: Target) -> HemGores | None:
    """Find the gores of a skirt by its hem; None where that has not a corner at the end of each of their seams.

    A gore is cut straight across at the hem, at a right angle to its middle. Its sides slant, so where two are sewn
    together the hem turns by the angle between their middles, and the whole hem by that of all of them: 2 pi is a full
    circle. Folds change none of it (`EdgeTurn`). Gores whose hems are curved, so that they hang level, leave no corner.
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
