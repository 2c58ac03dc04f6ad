"""A skirt of equal gores with straight sides that stands by itself: a pyramid without a top, each gore flat."""

from __future__ import annotations

import numpy as np
from garmentq.core.garment.garment import Garment


def stand_gores(garment: Garment) -> np.ndarray:
    """Return where the nodes of a skirt are [m], shape [node_count, 3], whose only panels are gores in their order."""
    panels = garment.pattern.panels
    nodes = np.zeros((len(garment.nodes), 3))
    for number, panel in enumerate(panels):
        mine = garment.panel_of_uv == number
        low, high = panel.points[:, 1].min(), panel.points[:, 1].max()
        widths = [np.ptp(panel.points[panel.points[:, 1] == end, 0]) for end in (low, high)]
        hem, top = (0.5 * width / np.tan(np.pi / len(panels)) for width in widths)  # from the axis
        across = garment.uv[mine, 0] - panel.points[:, 0].mean()
        up = (garment.uv[mine, 1] - low) / (high - low)
        turn = 2.0 * np.pi * number / len(panels)
        outward, along = (np.array([np.sin(at), 0.0, np.cos(at)]) for at in (turn, turn + np.pi / 2))
        place = np.outer(hem + up * (top - hem), outward) + np.outer(across, along)
        rise = np.sqrt((high - low) ** 2 - (hem - top) ** 2)
        nodes[garment.uv_node[mine]] = place + np.outer(up, [0.0, rise, 0.0])
    return nodes
