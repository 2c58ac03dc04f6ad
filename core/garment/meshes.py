"""The four meshes of one recovered garment: node positions that share the garment's topology."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Meshes:
    """Describe the node positions of one garment's meshes; faces, rest triangles and contours are the garment's.

    Attributes:
        graded: The graded pattern's drape, before deforming [m], shape [node_count, 3].
        detail: The drape deformed onto the scan [m], shape [node_count, 3].
        simulation: The recovered pattern's equilibrium [m], shape [node_count, 3], or None where the method fits none.
        redraped: The recovered pattern draped from its rest placement [m], shape [node_count, 3]; None likewise.
    """

    graded: np.ndarray
    detail: np.ndarray
    simulation: np.ndarray | None = None
    redraped: np.ndarray | None = None

    @property
    def drape_on_scan(self) -> np.ndarray:
        """Return the nodes of the last drape that begins on the scan [m]: the recovered or the graded pattern's."""
        return self.graded if self.simulation is None else self.simulation

    def __iter__(self) -> Iterator[tuple[str, np.ndarray]]:
        """Iterate over (file name, nodes) of the meshes that exist, in the order in which they are made."""
        yield "graded", self.graded
        yield "detail", self.detail
        if self.simulation is not None:
            yield "simulation", self.simulation
        if self.redraped is not None:
            yield "redrape", self.redraped
