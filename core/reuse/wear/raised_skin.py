"""Raise a wearer's skin to the garments below another one, and measure how two garments overlie."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...body.exposed import ExposedSurface
from ...cloth.settings import SelfContactSettings
from ...garment.garment import Garment
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import vertex_normals
from ...geometry.intersections import intersecting_pairs
from ...geometry.surface import TriangleSurface
from ...recover.drape.wearer import WearerGeometry

RAISED_SKIN_CLEARANCE = 2.0 * SelfContactSettings().thickness
"""Distance of the raised skin from the cloth under it [m]: two thicknesses, so that cloth outside the raised skin
touches none of the faces between its nodes."""

SKIN_RAISING_RADIUS = 0.04
"""Distance within which feet on the skin raise it [m]: vertices of bodies and of coarse cloth are 2 to 3 cm apart."""

MAX_SKIN_RAISE = 0.06
"""Largest height by which skin is raised [m]: cloth further from the skin (a skirt) supports no other cloth."""

HEIGHT_SMOOTHING_ITERATIONS = 4
"""Number of times that heights are averaged with their neighbours', never below what the cloth needs."""


def raise_skin_over(wearer: WearerGeometry, inner: Garment) -> WearerGeometry:
    """Return the geometry of a wearer with the skin raised outside of a garment, for cloth that goes over it.

    Each place of the skin is raised to the cloth around it, up to `MAX_SKIN_RAISE`.

    Args:
        wearer: The wearer.
        inner: The garment below the other one, nodes at rest on the wearer.
    """
    body, faces = wearer.body, inner.faces
    normals = vertex_normals(inner.nodes, faces)
    points = np.concatenate([inner.nodes, inner.nodes[faces].mean(axis=1)])
    facing = np.concatenate([normals, normals[faces].mean(axis=1)])
    found = wearer.exposed.closest(points)
    below = (facing * wearer.exposed.normals[found.face]).sum(axis=1) > 0.0  # a hand beside trousers is not under them
    below &= found.distance < MAX_SKIN_RAISE
    needed = np.zeros(len(body.vertices))
    if below.any():
        tree, feet = cKDTree(body.vertices), found.foot[below]
        for vertices, height in zip(
            tree.query_ball_point(feet, SKIN_RAISING_RADIUS), found.distance[below] + RAISED_SKIN_CLEARANCE, strict=True
        ):
            needed[vertices] = np.maximum(needed[vertices], height)
    heights, edges = needed, HalfEdges.of(body.faces, len(body.vertices)).edges
    count = np.maximum(np.bincount(edges.ravel(), minlength=len(heights)), 1)
    for _ in range(HEIGHT_SMOOTHING_ITERATIONS):
        around = np.bincount(edges.ravel(), heights[edges[:, ::-1]].ravel(), minlength=len(heights)) / count
        heights = np.maximum(needed, 0.5 * (heights + around))
    return wearer.raised(np.minimum(heights, MAX_SKIN_RAISE + RAISED_SKIN_CLEARANCE))


def measure_layers(inner: Garment, outer: Garment, skin: ExposedSurface) -> dict[str, float | None]:
    """Measure one garment over another on the skin of their wearer. `layers.crossing_faces` counts the faces of both
    that cross the other garment, `inner.self_intersecting_faces` those of the lower one that cross itself.
    `layers.depth_mm` is the depth of the upper one below it: the greatest distance of a node or face centre behind the
    lower one's surface, if the way from the skin outward through it meets the lower one within `MAX_SKIN_RAISE`. The
    second condition excludes cloth beyond a waistband that stands off the body."""
    first, faces = len(inner.faces), np.concatenate([inner.faces, outer.faces + len(inner.nodes)])
    pairs = intersecting_pairs(np.concatenate([inner.nodes, outer.nodes]), faces)
    below_of = (pairs < first).sum(axis=1)
    points = np.concatenate([outer.nodes, outer.nodes[outer.faces].mean(axis=1)])
    below = TriangleSurface(inner.nodes, inner.faces)
    found = below.closest(points)
    normal = found.interpolate(vertex_normals(inner.nodes, inner.faces), inner.faces)
    rim = found.interpolate(below.half_edges.border_vertices[:, None].astype(float), inner.faces)[:, 0] > 1.0 - 1e-6
    behind = np.flatnonzero((((points - found.foot) * normal).sum(axis=1) < 0.0) & ~rim)
    behind = behind[is_covered(points[behind], skin, inner)]
    return {
        "layers.crossing_faces": float(len(np.unique(pairs[below_of == 1]))),
        "under.self_intersecting_faces": float(len(np.unique(pairs[below_of == 2]))),
        "layers.depth_mm": 1e3 * float(found.distance[behind].max(initial=0.0)),
    }


def is_covered(points: np.ndarray, skin: ExposedSurface, cloth: Garment) -> np.ndarray:
    """Check for each point [m], shape [n, 3], whether the way outward from the skin through it meets cloth beyond it.
    The way is a straight line of `MAX_SKIN_RAISE` away from the nearest skin (Moeller and Trumbore 1997)."""
    _, ways = skin.measure(points)
    corner, *others = (cloth.nodes[cloth.faces[:, k]] for k in range(3))
    sides = [other - corner for other in others]
    covered = np.zeros(len(points), dtype=bool)
    for n, (point, direction) in enumerate(zip(points, ways, strict=True)):
        across = np.cross(direction, sides[1])
        volume = (across * sides[0]).sum(axis=1)
        volume = np.where(np.abs(volume) < 1e-18, np.inf, volume)  # parallel to the way
        first = (across * (point - corner)).sum(axis=1) / volume
        turned = np.cross(point - corner, sides[0])
        second = (turned @ direction) / volume
        along = (turned * sides[1]).sum(axis=1) / volume
        meets = (first >= 0.0) & (second >= 0.0) & (first + second <= 1.0) & (along > 0.0) & (along < MAX_SKIN_RAISE)
        covered[n] = meets.any()
    return covered
