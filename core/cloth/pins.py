"""Nodes pinned at given positions: a waistband, a pin, a clamp."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..run.errors import BadInput

__all__ = ["Pins", "PinsBad", "move_pins"]


class PinsBad(BadInput):
    """The pinned nodes are not on the cloth; name one of the garment's contours."""

    code = "simulate.pins_bad"


@dataclass(frozen=True)
class Pins:
    """Describe nodes pinned to points: fixed where `stiffness` is None, else by springs.

    Attributes:
        nodes: Pinned nodes, shape [pin_count].
        points: Where they are pinned [m], shape [pin_count, 3].
        stiffness: Spring stiffness of each node [N/m], or None to fix them.
        directions: Weight of the spring along x, y and z; (0, 1, 0) pins the height only, as a waistband's friction.
    """

    nodes: np.ndarray
    points: np.ndarray
    stiffness: float | None = None
    directions: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        """Check the shapes; raise `PinsBad` where nodes and points do not match, or a fixed node has free
        directions."""
        if np.shape(self.points) != (len(self.nodes), 3) or not np.isfinite(self.points).all():
            raise PinsBad("pins need one finite point for each node.")
        if self.stiffness is None and self.directions != (1.0, 1.0, 1.0):
            raise PinsBad("pins along some directions only need a stiffness.")

    def without(self, nodes: np.ndarray) -> Pins:
        """Return the pins without those of some nodes, shape [count]."""
        kept = ~np.isin(self.nodes, nodes)
        return replace(self, nodes=self.nodes[kept], points=np.asarray(self.points)[kept])


def move_pins(nodes: np.ndarray, pins: Pins | None, max_step: float) -> np.ndarray:
    """Return nodes [m], [node_count, 3], with the fixed ones moved towards their pins by at most `max_step` [m]."""
    if pins is None or pins.stiffness is not None:
        return nodes
    nodes = nodes.copy()
    displacement = np.asarray(pins.points) - nodes[pins.nodes]
    length = np.linalg.norm(displacement, axis=1, keepdims=True)
    nodes[pins.nodes] += displacement * np.minimum(1.0, max_step / np.maximum(length, 1e-300))
    return nodes
