"""Repair a damaged target: spikes, orientation, and borders that are damage."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...garment.garment import Garment
from ...garment.shown_sides import find_shown_sides, select_shown_faces
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import unit, vertex_normals
from ...geometry.rim import Rim
from ...geometry.surface import ClosestPoints, TriangleSurface
from ...scan.contours.noise import smooth_noise
from ...scan.contours.spikes import flatten_spikes
from ...scan.contours.target import Contour, Target

UNSIGNED_SHARE = 0.25
"""Share of normals against the source after the vote above which signs are not used. Wrong folds give about 0.05."""


@dataclass(frozen=True)
class PreparedTarget:
    """Describe the repaired target with what the losses need.

    Attributes:
        surface: Closest points on it.
        normals: Unit vertex normals after the vote, shape [vertex_count, 3].
        shares: Share of the area at each vertex, sums to 1, shape [vertex_count].
        unsigned: Use the normals' axes only.
        reversed: The vote reversed all normals.
        spikes: Number of vertices moved.
        pairs: Matched contours, source first.
        rim: The border that is no matched contour.
        sides: The side of each of the garment's faces that is compared with it (`find_shown_sides`).
        shown_faces: The faces of which one is, that side outwards, shape [n, 3].
    """

    surface: TriangleSurface
    normals: np.ndarray
    shares: np.ndarray
    unsigned: bool
    reversed: bool
    spikes: int
    pairs: tuple[tuple[Contour, Contour], ...]
    rim: Rim
    sides: np.ndarray
    shown_faces: np.ndarray

    def on_rim(self, points: ClosestPoints) -> np.ndarray:
        """Return which closest points are on a rim: there the source covers a hole or extends beyond a cut."""
        return self.rim.contains(points)


def prepare_target(target: Target, garment: Garment, repair: bool) -> PreparedTarget:
    """Repair a target by comparison with the graded drape and match its contours by name.

    Args:
        target: The surface to be reached.
        garment: Graded drape with its named contours.
        repair: Move spikes and vote on the orientation; contours are matched in any case.
    """
    vertices = np.array(target.vertices, dtype=np.float64)
    spikes = np.zeros(len(vertices), dtype=bool)
    noise = 0.0
    if repair:
        vertices, spikes = flatten_spikes(vertices, target.faces)
        vertices, noise = smooth_noise(vertices, target.faces)
    normals = vertex_normals(vertices, target.faces)
    file_normals = np.asarray(target.normals, dtype=np.float64)
    against = (normals * file_normals).sum(1) < 0
    if noise == 0.0:  # a noisy surface's own normals are not valid for the smoothed one
        normals[against & ~spikes] *= -1
    surface = TriangleSurface(vertices, target.faces)
    turned, unsigned = False, False
    if repair:
        nodes, faces = np.asarray(garment.nodes, np.float64), np.asarray(garment.faces, np.int64)
        turned, unsigned = vote_orientation(surface, normals, nodes, faces)
        normals = -normals if turned else normals
    sides = find_shown_sides(garment, surface, normals)
    pairs = match_contours(garment.contours, target.contours)
    areas = surface.vertex_areas
    return PreparedTarget(
        surface=surface,
        normals=normals,
        shares=areas / areas.sum(),
        unsigned=unsigned,
        reversed=turned,
        spikes=int(spikes.sum()),
        pairs=pairs,
        rim=_find_rim(target, pairs),
        sides=sides,
        shown_faces=select_shown_faces(garment.faces, sides),
    )


def vote_orientation(
    surface: TriangleSurface, normals: np.ndarray, nodes: np.ndarray, faces: np.ndarray
) -> tuple[bool, bool]:
    """Find whether the target's normals are reversed as a whole, and whether their signs are inconsistent."""
    mesh_normals = vertex_normals(nodes, faces)
    cosine = (mesh_normals * unit(surface.closest(nodes).interpolate(normals, surface.faces))).sum(axis=1)
    reversed_ = bool(cosine.mean() < 0)
    share = float(((-cosine if reversed_ else cosine) < 0).mean())
    # signs may also differ between neighbours: then they average out at the closest points
    edges = surface.half_edges
    discord = float(((normals[edges.tail] * normals[edges.head]).sum(axis=1) < 0).mean())
    return reversed_, max(share, discord) > UNSIGNED_SHARE


def match_contours(source: tuple[Contour, ...], target: tuple[Contour, ...]) -> tuple[tuple[Contour, Contour], ...]:
    """Pair contours of the same name that are trusted on both sides; the others stay unmatched."""
    named = {c.name: c for c in target if c.trusted and len(c.vertices) >= 3}
    return tuple((c, named[c.name]) for c in source if c.trusted and len(c.vertices) >= 3 and c.name in named)


def _find_rim(target: Target, pairs: tuple[tuple[Contour, Contour], ...]) -> Rim:
    """Find the border that belongs to no matched contour; a vertex shared with a contour is the contour's."""
    count = len(target.vertices)
    on_contour = np.zeros(count, dtype=bool)
    for _, contour in pairs:
        on_contour[contour.vertices] = True
    edges = HalfEdges.of(target.faces, count)
    border = edges.border[~(on_contour[edges.tail] & on_contour[edges.head])[edges.border]]
    rim = Rim.of(edges, target.faces, border)
    return replace(rim, vertices=rim.vertices & ~on_contour)
