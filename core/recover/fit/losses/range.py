"""Keep a fabric within the range of real cloth (the material term of thesis eq. 3.7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....cloth.fabric import Fabric
from ....cloth.fabrics import load_fabrics

STIFFNESSES = ("H00", "H01", "H11", "H22", "k")
"""The parameters of thesis eq. 3.11, in the order of the logarithms."""

LIBRARY_RANGE_FACTOR = 2.0
"""Factor by which the library's range is extended at both ends: its 19 fabrics are not all that exist."""

MAX_STIFFNESS_COUPLING = 0.95
"""Largest ratio H01 / sqrt(H00 H11): at 1 the cloth could be stretched one way without resistance."""


@dataclass(frozen=True)
class RangeLoss:
    """Penalise stiffnesses outside the library's range, as logarithms; a pure number.

        L = sum_i relu(low_i - g_i)^2 + relu(g_i - high_i)^2 + relu(g_01 - (g_00 + g_11) / 2 - ln c)^2
    g_i: ln of H00, H01, H11, H22, k, in this order; low and high: the library's range of the ratio to the weight at the
    fabric's own weight, widened; c `MAX_STIFFNESS_COUPLING`. The last term keeps H positive definite.

    **Deviation**: the thesis has relu(1e-6 - value), which only excludes values that are not positive; logarithms
    always give positive values, but from a single drape diverge beyond real cloth.

    Attributes:
        low, high: Of the logarithms, shape [5].
    """

    low: np.ndarray
    high: np.ndarray

    @classmethod
    def of(cls, fabric: Fabric) -> RangeLoss:
        """Return the library's range at a fabric's weight, extended to the fabric itself."""
        ratios = np.log([[getattr(each, name) / each.density for name in STIFFNESSES] for each in load_fabrics()])
        weight, logs = np.log(fabric.density), logarithms(fabric)
        low, high = (
            ratios.min(0) + weight - np.log(LIBRARY_RANGE_FACTOR),
            ratios.max(0) + weight + np.log(LIBRARY_RANGE_FACTOR),
        )
        return cls(np.minimum(low, logs), np.maximum(high, logs))

    def evaluate(self, logs: np.ndarray) -> tuple[float, np.ndarray]:
        """Return L and its gradient, shape [5], at the logarithms of the stiffnesses, shape [5]."""
        below, above = np.maximum(self.low - logs, 0.0), np.maximum(logs - self.high, 0.0)
        coupled = max(float(logs[1] - 0.5 * (logs[0] + logs[2]) - np.log(MAX_STIFFNESS_COUPLING)), 0.0)
        gradient = 2.0 * (above - below)
        gradient[:3] += 2.0 * coupled * np.array([-0.5, 1.0, -0.5])
        return float((below**2 + above**2).sum() + coupled**2), gradient


def logarithms(fabric: Fabric) -> np.ndarray:
    """Return ln of `STIFFNESSES`, shape [5]."""
    return np.log([getattr(fabric, name) for name in STIFFNESSES])
