"""Transfer a garment's 3D nodes to another mesh of the same pattern."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from .control import map_controls
from .errors import PatternMismatch
from .garment import Garment
from .pattern import EdgeRef

TRIANGLE_CANDIDATE_COUNT = 16
"""Number of triangles tried for each point, nearest centroids first: on even meshes it is among the first 6."""


def resample(source: Garment, nodes: np.ndarray, target: Garment) -> np.ndarray:
    """Return the target's nodes on the source's surface. The source's flat mesh is first moved to the target pattern's
    control points. Vertices on the outline are interpolated along their edge by arc length, so that both sides of a
    seam agree; inner ones in their triangle. A node is the mean over its uv vertices.

    Args:
        source: The garment that the nodes belong to.
        nodes: 3D positions [m], shape [source node_count, 3].
        target: Another mesh of a pattern with the same panels and numbers of control points.

    Returns:
        3D positions [m], shape [target node_count, 3].

    Raises:
        PatternMismatch: where the panels differ.
    """
    panels = [(panel.name, len(panel.points)) for panel in source.pattern.panels]
    if panels != [(panel.name, len(panel.points)) for panel in target.pattern.panels]:
        raise PatternMismatch
    flat = map_controls(source).apply(target.pattern.points)
    found = np.zeros((len(target.uv), 3))
    on_outline = np.zeros(len(target.uv), bool)
    for panel in target.pattern.panels:
        for i in range(len(panel.edges)):
            ref = EdgeRef(panel.name, i)
            along = target.edge_uv[ref]
            found[along] = _resample_polyline(nodes[source.uv_node[source.edge_uv[ref]]], len(along))
            on_outline[along] = True
    for index in range(len(target.pattern.panels)):
        points = np.flatnonzero((target.panel_of_uv == index) & ~on_outline)
        if len(points):
            faces = source.panel_of_face == index
            corner, weight = locate(flat, source.uv_faces[faces], target.uv[points])
            found[points] = np.einsum("nk,nkd->nd", weight, nodes[source.uv_node[corner]])
    count = len(target.nodes)
    weight = np.bincount(target.uv_node, minlength=count)
    return np.stack([np.bincount(target.uv_node, found[:, k], count) / weight for k in range(3)], axis=1)


def _resample_polyline(line: np.ndarray, count: int) -> np.ndarray:
    """Return `count` points of a polyline whose vertices are uniform in rest length, shape [count, 3]."""
    old, new = np.linspace(0.0, 1.0, len(line)), np.linspace(0.0, 1.0, count)
    return np.stack([np.interp(new, old, line[:, k]) for k in range(line.shape[1])], axis=1)


def locate(
    uv: np.ndarray, faces: np.ndarray, points: np.ndarray, is_within: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (uv indices) and barycentric weights, shape [n, 3] each, of the triangle at each point. A
    point outside all triangles gets the one it is least outside of; its weights are clamped to zero, or without
    `is_within` kept, which extrapolates the triangle."""
    a, b, c = (uv[faces[:, k]] for k in range(3))
    candidates = (
        cKDTree((a + b + c) / 3.0)
        .query(points, k=min(TRIANGLE_CANDIDATE_COUNT, len(faces)))[1]
        .reshape(len(points), -1)
    )
    u, v, w = (b - a)[candidates], (c - a)[candidates], points[:, None] - a[candidates]
    area = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    area = np.where(np.abs(area) < 1e-18, np.inf, area)
    second = (w[..., 0] * v[..., 1] - w[..., 1] * v[..., 0]) / area
    third = (u[..., 0] * w[..., 1] - u[..., 1] * w[..., 0]) / area
    weight = np.stack([1.0 - second - third, second, third], axis=-1)
    best = weight.min(axis=-1).argmax(axis=1)
    row = np.arange(len(points))
    chosen = np.maximum(weight[row, best], 0.0) if is_within else weight[row, best]
    return faces[candidates[row, best]], chosen / chosen.sum(axis=1, keepdims=True)
