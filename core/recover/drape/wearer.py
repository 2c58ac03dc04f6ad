"""Describe the wearer's geometry: the body with its distance fields."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...body.body import Body
from ...body.distance import DistanceGrid
from ...body.exposed import ExposedSurface
from ...body.raised_distance import RaisedDistance
from ...body.skinning import rest_body
from .pose_path import PosePath


@dataclass(frozen=True)
class WearerGeometry:
    """Describe the wearer's body with distance grids, exposed skin and frames of its pose.

    Each field takes up to a second and is computed on first use.

    Attributes:
        body: The wearer.
        offset: How far its skin was moved out from the registered body [m], shape [vertex_count]; None for not at all.
    """

    body: Body
    offset: np.ndarray | None = None

    @cached_property
    def rest(self) -> Body:
        """Return the same person in the T-pose."""
        return rest_body(self.body)

    @cached_property
    def grid(self) -> DistanceGrid:
        """Return the distance to the wearer's own mesh in its pose."""
        return DistanceGrid.from_mesh(self.body.vertices, self.body.faces)

    @cached_property
    def raised_distance(self) -> RaisedDistance:
        """Return the distance to the wearer with raised skin, to first order."""
        return RaisedDistance.of(self.body, self.grid)

    @cached_property
    def rest_grid(self) -> DistanceGrid:
        """Return the distance to `rest`."""
        return DistanceGrid.from_mesh(self.rest.vertices, self.rest.faces)

    @cached_property
    def exposed(self) -> ExposedSurface:
        """Return the exposed skin of the wearer's own mesh, from which delivered meshes are cleared and measured."""
        return ExposedSurface.of(self.body)

    @cached_property
    def way(self) -> PosePath:
        """Return the frames in which the wearer takes the pose."""
        return PosePath.of(self.body, self.exposed)

    def raised(self, heights: np.ndarray) -> WearerGeometry:
        """Return the geometry, with new fields, of a wearer with skin raised by heights [m], shape [vertex_count]."""
        return replace(
            self, body=self.body.raised(heights), offset=heights if self.offset is None else self.offset + heights
        )
