"""Make a recovered pattern's curves fair, and update its flat mesh."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ...garment.control import update_flat_mesh
from ...garment.errors import PanelCrossing, PanelDegenerate
from ...garment.fairness import fair_curves
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.validity import check_outline
from ..proved_corner import ProvedCorner
from .locks import find_locked_points


def fair_garment(garment: Garment, base: Pattern, locked: np.ndarray, proved: Collection[ProvedCorner] = ()) -> Garment:
    """Return a garment whose boundary has no corner where its base pattern has none and the scan proves none.

    Nodes stay. Returned unchanged where nothing has to bend, or a panel would cross itself.

    Args:
        garment: The recovered pattern, meshed.
        base: The base pattern.
        locked: Locked effective coordinates, bool, shape [p]; see `find_locked_coordinates`.
        proved: Corners that the scan proves.
    """
    pattern = garment.pattern
    corners = [(panel.name, i) for panel in pattern.panels for i in range(len(panel.points))]
    fixed = {corner for corner, is_held in zip(corners, find_locked_points(base, locked), strict=True) if is_held}
    fair = fair_curves(pattern, base, fixed, {corner.join: corner.angle for corner in proved})
    if fair is pattern:
        return garment
    try:
        for panel in fair.panels:
            check_outline(panel)
    except (PanelCrossing, PanelDegenerate):
        return garment
    return update_flat_mesh(garment, fair)
