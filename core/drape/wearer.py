"""The geometry of the wearer: everything a stage may ask about where the body is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from ..body import Body, DistanceGrid, ExposedSurface, rest_body
from .carry import Way


@dataclass(frozen=True)
class WearerGeometry:
    """The wearer's body with the distance grids that every drape on it needs.

    Each grid takes about a second and is filled when it is first asked for.

    Attributes:
        body: The wearer.
    """

    body: Body

    @cached_property
    def rest(self) -> Body:
        """Return the same person in the T-pose."""
        return rest_body(self.body)

    @cached_property
    def grid(self) -> DistanceGrid:
        """Return the distance to the wearer's own mesh in its pose."""
        return DistanceGrid.from_mesh(self.body.vertices, self.body.faces)

    @cached_property
    def rest_grid(self) -> DistanceGrid:
        """Return the distance to `rest`."""
        return DistanceGrid.from_mesh(self.rest.vertices, self.rest.faces)

    @cached_property
    def exposed(self) -> ExposedSurface:
        """Return the exposed skin of the wearer's own mesh: what every delivered mesh is cleared of and measured by."""
        return ExposedSurface.of(self.body)

    @cached_property
    def way(self) -> Way:
        """Return the frames in which the wearer takes the pose."""
        return Way.of(self.body, self.exposed)
