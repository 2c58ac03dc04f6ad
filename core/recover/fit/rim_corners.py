"""Find corners that the scan proves: at a seam's end the rim turns by more than elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ...garment.editing.partners import mirror_corners
from ...garment.fairness import MAX_SMOOTH_CORNER_ANGLE, SmoothJoin, boundary_edges, find_smooth_joins
from ...garment.garment import Garment
from ...garment.pattern import EdgeRef, Pattern
from ...geometry.geometry import rim_turns
from ...scan.contours.target import Contour, Target
from ..proved_corner import ProvedCorner

RIM_WINDOW_LENGTH = 0.02
"""Length on either side of a seam's end within which the rim's corner is searched [m]: registration finds the place of
a seam on the surface to a centimetre, on two of our targets to 14 mm."""

RIM_ARM_LENGTH = 0.04
"""Length of rim beyond the window on either side that gives its curvature without a corner [m]: with both windows and
arms 12 cm, a third of the narrowest cuffs."""

MIN_CORNER_SIGMA_COUNT = 3.0
"""Number of standard deviations by which a corner has to be larger than `MAX_SMOOTH_CORNER_ANGLE`."""

MIN_CORNER_STD = np.radians(0.5)
"""Lower bound of a corner's standard deviation [rad]: smaller corners are not corrected in patterns either."""

MAX_CORNER_STD = MAX_SMOOTH_CORNER_ANGLE / 2.0
"""Standard deviation above which no corner is proved [rad]: the corner's angle has to be known within what is smooth.
Without it 1 of 60 skirts with 1 mm of noise got a corner of 41 degrees in place of 20."""

MIN_RIM_PLACE_COUNT = 8
"""Number of places on the rim without a seam that are needed to estimate its own turning."""


def prove_corners(garment: Garment, nodes: np.ndarray, target: Target, base: Pattern) -> tuple[ProvedCorner, ...]:
    """Find the corners of a scan's rim at the ends of seams where the base pattern is smooth.

    On a developable surface a rim turns at each vertex by pi less the sum of the faces' angles: the turn of its flat
    outline, independent of folds. A corner is the rim's turn within `RIM_WINDOW_LENGTH` of a seam's end, less that at
    the rate of its arms. Its standard deviation is that of the same figure at all other places of the rim, and of the
    rim on the other side of the body, without the corners themselves: noise, teeth and stretched cloth turn a rim there
    as much. Mirror images count as one. Only visible, trusted contours are used. `EdgeTurn` finds corners at unknown
    places; at a given one its Gaussian window would lose turn with the distance of the true place.

    Args:
        garment: The recovered pattern's mesh, contours named.
        nodes: Its nodes on the target [m], shape [node_count, 3].
        target: The surface as the scan shows it, with named contours.
        base: The base pattern with the same panels.
    """
    rims = {
        contour.name: _Rim.of(target, contour) for contour in target.contours if contour.trusted and not contour.hidden
    }
    places: dict[SmoothJoin, tuple[str, float]] = {}
    for join in find_smooth_joins(base):
        panel, index = join.corners[0]
        node = int(garment.uv_node[garment.edge_uv[EdgeRef(panel, index)][0]])
        names = [contour.name for contour in garment.contours if node in contour.vertices and contour.name in rims]
        if not names or not _is_free(base, join):
            continue
        at = rims[names[0]].nearest(nodes[node])
        if at is not None:
            places[join] = names[0], at
    spreads = _spreads(rims, places)
    measured = {join: (rims[name].corner(at), spreads[name], name) for join, (name, at) in places.items()}
    images = mirror_corners(base) if base.symmetric else {}
    found = []
    for join in measured:
        same = [measured[other] for other in {join, *_mirror_joins(join, images, measured)}]
        angles = np.array([angle for angle, _, _ in same])
        if not np.isfinite(angles).all():
            continue
        angle = float(angles.mean())
        std = max(MIN_CORNER_STD, max(spread for _, spread, _ in same), float(np.ptp(angles)) / 2.0)
        if std <= MAX_CORNER_STD and abs(angle) - MIN_CORNER_SIGMA_COUNT * std > MAX_SMOOTH_CORNER_ANGLE:
            name = measured[join][2]
            found.append(ProvedCorner(join, name.partition(".")[0], angle, std))
    return tuple(found)


@dataclass(frozen=True)
class _Rim:
    """Describe a flattened rim of the target.

    Attributes:
        points: Its vertices in order [m], shape [count, 3].
        arc: Arc length up to each of them [m], shape [count].
        part: Half of the lengths of both sides [m], shape [count].
        turn: Turn at each, positive where convex [rad], shape [count].
    """

    points: np.ndarray
    arc: np.ndarray
    part: np.ndarray
    turn: np.ndarray

    @classmethod
    def of(cls, target: Target, contour: Contour) -> _Rim:
        """Return the rim along a contour of the target."""
        points = target.vertices[contour.vertices]
        side = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
        turn = rim_turns(target.vertices[target.faces], target.faces, contour.vertices)
        arc = np.concatenate([[0.0], np.cumsum(side)[:-1]])
        return cls(points, arc, 0.5 * (side + np.roll(side, 1)), turn)

    @property
    def length(self) -> float:
        """Return the length of the rim [m]."""
        return float(self.part.sum())

    def nearest(self, place: np.ndarray) -> float | None:
        """Return the arc length of the nearest vertex to a place [m]; None if beyond `RIM_WINDOW_LENGTH`."""
        distance = np.linalg.norm(self.points - place, axis=1)
        nearest = int(np.argmin(distance))
        return float(self.arc[nearest]) if distance[nearest] <= RIM_WINDOW_LENGTH else None

    def distance(self, at: float) -> np.ndarray:
        """Return the distance of each vertex from an arc length along the rim [m], shape [count]."""
        distance = np.abs(self.arc - at)
        return np.asarray(np.minimum(distance, self.length - distance))

    def corner(self, at: float) -> float:
        """Return the rim's turn within the window beyond the rate of its arms [rad]; NaN on too short a rim."""
        apart = self.distance(at)
        window, arms = (
            apart <= RIM_WINDOW_LENGTH,
            (apart > RIM_WINDOW_LENGTH) & (apart <= RIM_WINDOW_LENGTH + RIM_ARM_LENGTH),
        )
        if self.length < 2.0 * (RIM_WINDOW_LENGTH + RIM_ARM_LENGTH) or not window.any() or arms.sum() < 2:
            return float("nan")
        rate = self.turn[arms].sum() / self.part[arms].sum()
        return float(self.turn[window].sum() - rate * self.part[window].sum())

    def elsewhere(self, places: Iterable[float]) -> np.ndarray:
        """Return the corners [rad] at all vertices whose windows contain none of some places, with these smoothed."""
        turn, free = self.turn.copy(), np.ones(len(self.turn), dtype=bool)
        for at in places:
            apart = self.distance(at)
            window = apart <= RIM_WINDOW_LENGTH
            free &= apart > 2.0 * RIM_WINDOW_LENGTH
            corner = self.corner(at)
            if np.isfinite(corner):
                even = (self.turn[window].sum() - corner) / self.part[window].sum()
                turn[window] = even * self.part[window]
        rim = _Rim(self.points, self.arc, self.part, turn)
        found = np.array([rim.corner(at) for at in self.arc[free]])
        corners: np.ndarray = found[np.isfinite(found)]
        return corners


def _spreads(rims: Mapping[str, _Rim], places: Mapping[SmoothJoin, tuple[str, float]]) -> dict[str, float]:
    """Return the RMS of the corners elsewhere on each rim and its other side's [rad], by name; infinite if too few."""
    sides: dict[str, list[np.ndarray]] = {}
    for name, rim in rims.items():
        elsewhere = rim.elsewhere({at for other, at in places.values() if other == name})
        sides.setdefault(name.partition(".")[0], []).append(elsewhere)
    spreads = {}
    for name in rims:
        corners = np.concatenate(sides[name.partition(".")[0]])
        enough = len(corners) >= MIN_RIM_PLACE_COUNT
        spreads[name] = float(np.sqrt(np.mean(corners**2))) if enough else float("inf")
    return spreads


def _is_free(base: Pattern, join: SmoothJoin) -> bool:
    """Return whether the boundary at a join is unsewn."""
    sewn = {ref for seam in base.seams for ref in (seam.a, seam.b)}
    return not any(edge in sewn for edge in boundary_edges(base, join))


def _mirror_joins(
    join: SmoothJoin,
    images: Mapping[tuple[str, int], list[tuple[tuple[str, int], np.ndarray]]],
    among: Iterable[SmoothJoin],
) -> list[SmoothJoin]:
    """Return the mirror images of a join among others."""
    return [
        other
        for other in among
        if len(other.corners) == len(join.corners)
        and all(any(image in other.corners for image, _ in images.get(corner, [])) for corner in join.corners)
    ]
