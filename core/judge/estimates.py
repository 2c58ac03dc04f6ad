"""The estimates of a fit and their uncertainty, as flat numbers for a database."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..cloth.fabric import FabricEstimate
from ..run.units import MM_PER_M


def summarise_estimates(
    estimates: Sequence[FabricEstimate], point_std: np.ndarray | None = None
) -> dict[str, float | None]:
    """Return the estimates of each fabric parameter, and the uncertainty of the control points.

    Args:
        estimates: Of the fit; empty where the method fits none.
        point_std: Posterior standard deviation of the control points [m], shape [point_count, 2], or None.

    Returns:
        `fabric.NAME` in N/m, N m or kg/m2, None where it is not identifiable; `fabric.NAME.std`, of the natural
        logarithm; `fabric.NAME.identifiable`, 1 or 0; `pattern.point_std_mm.mean` and `.max`.
    """
    found: dict[str, float | None] = {}
    for each in estimates:
        found[f"fabric.{each.name}"] = each.value if each.identifiable else None
        found[f"fabric.{each.name}.std"] = each.std
        found[f"fabric.{each.name}.identifiable"] = float(each.identifiable)
    if point_std is not None:
        found["pattern.point_std_mm.mean"] = MM_PER_M * float(point_std.mean())
        found["pattern.point_std_mm.max"] = MM_PER_M * float(point_std.max())
    return found
