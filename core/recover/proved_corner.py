"""Describe corners that the scan proves where the base pattern is smooth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..garment.fairness import SmoothJoin
from ..run.finding import Finding, FindingKind


@dataclass(frozen=True)
class ProvedCorner:
    """Describe a corner that the scan proves where the base pattern is smooth.

    Attributes:
        join: Its place in the pattern.
        contour: Name of its opening; both names where its mirror image was measured too.
        angle: Angle by which the rim turns there beyond its smooth course, positive where convex [rad].
        std: Standard deviation of `angle`, from the turning of the rim elsewhere [rad].
    """

    join: SmoothJoin
    contour: str
    angle: float
    std: float

    def describe(self) -> Finding:
        """Return the finding with its evidence: place, contour, angle and standard deviation [degrees]."""
        where = " and ".join(f"'{panel}' at point {index}" for panel, index in self.join.corners)
        message = (
            f"The scan has a corner at its {self.contour} where the base pattern is smooth: {where}, "
            f"{np.degrees(self.angle):.1f} degrees with a standard deviation of {np.degrees(self.std):.1f}; "
            f"the pattern keeps it."
        )
        evidence = {
            "corners": [list(corner) for corner in self.join.corners],
            "contour": self.contour,
            "angle_deg": float(np.round(np.degrees(self.angle), 3)),
            "std_deg": float(np.round(np.degrees(self.std), 3)),
        }
        return Finding(FindingKind.CORNER, message, float(np.degrees(self.angle)), evidence)
