"""Find contours with teeth, which separate the border of a scan cut along its triangles from a hem."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.curves import Curve
from ...geometry.geometry import area_vectors, unit

COARSE_ZIGZAG_LENGTH = 0.02
"""Length over which a zigzag wider than the triangles is measured [m]: of a cut of a coarse mesh that was refined
later, or of labels coarser than the scan. A hem's folds and its design's corners are longer."""

MIN_FINE_ZIGZAG_RATIO = 0.35
"""Ratio of the zigzag's height between neighbouring vertices to half the chord from which a contour was cut. 37
designed contours of scans with 5 to 16 thousand faces had 0.00 to 0.15, 10 with 16 to 64 times the faces and 0.2 mm of
noise 0; 27 hems cut along triangles 0.57 to 1.7, and 3 whose rows of triangles run along the cut 0.01 to 0.16."""

MIN_COARSE_ZIGZAG_RATIO = 0.2
"""Ratio at `COARSE_ZIGZAG_LENGTH`: designed contours had 0.00 to 0.09, hems cut on coarse meshes 0.24 to 0.6."""

MIN_ZIGZAG_NOISE_RATIO = 1.5
"""Least ratio of the zigzag's height to the contour's roughness across the surface; noise is equal both ways."""

MAX_SMOOTH_ZIGZAG_SHARE = 0.85
"""Share of the limits up to which another contour of the same garment counts as uncut. Where all have a larger zigzag,
the whole garment was cut out along the triangles, and the zigzag shows nothing."""

MIN_NORMAL_AVERAGING_RADIUS = 0.01
"""Least radius over which the surface's normal is averaged at a contour [m]: many triangles of a dense scan."""


def find_cut_contours(loops: Mapping[str, np.ndarray], vertices: np.ndarray, faces: np.ndarray) -> frozenset[str]:
    """Name the contours with the teeth of a cut along triangles, where another contour of the garment has none.

    A cut leaves a zigzag in the surface, as high as half a triangle; waves of a hem leave the surface, design bends it
    one way over many vertices, and noise moves a border as much across the surface as in it. The height of a vertex
    over the chord of its neighbours, less the mean of its two neighbours' heights, is taken along the surface and
    across it; t and n are the medians of their sizes over half the chord. The teeth are sqrt(t^2 - n^2), and 0 where t
    is not well above n. Both are measured between neighbours and over `COARSE_ZIGZAG_LENGTH`.

    Args:
        loops: Vertex indices of the contours by name.
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Outward faces, shape [face_count, 3].
    """
    if not loops:
        return frozenset()
    centres, vectors = cKDTree(vertices[faces].mean(axis=1)), area_vectors(vertices, faces)
    zigzags = {name: _measure_zigzag(vertices[loop], centres, vectors) for name, loop in loops.items()}
    if min(zigzags.values()) > MAX_SMOOTH_ZIGZAG_SHARE:
        return frozenset()
    return frozenset(name for name, size in zigzags.items() if size > 1.0)


def _measure_zigzag(points: np.ndarray, centres: cKDTree, vectors: np.ndarray) -> float:
    """Return the height of a contour's teeth over the limit, the larger one of both lengths."""
    curve = Curve(points)
    found = _zigzag_height(points, centres, vectors) / MIN_FINE_ZIGZAG_RATIO
    count = round(curve.length / COARSE_ZIGZAG_LENGTH)
    if 8 <= count < len(points):
        found = max(found, _zigzag_height(curve.resample(count), centres, vectors) / MIN_COARSE_ZIGZAG_RATIO)
    return found


def _zigzag_height(points: np.ndarray, centres: cKDTree, vectors: np.ndarray) -> float:
    """Return the median height of the teeth over half the chord, without the noise."""
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    chord = after - before
    half = np.maximum(0.5 * np.linalg.norm(chord, axis=1), 1e-12)
    along = unit(chord)
    neighbours = centres.query_ball_point(points, max(MIN_NORMAL_AVERAGING_RADIUS, 2.0 * float(np.median(half))))
    normal = np.array([vectors[faces].sum(axis=0) for faces in neighbours])
    normal = unit(normal - (normal * along).sum(axis=1)[:, None] * along)
    rise = points - 0.5 * (before + after)
    sizes = []
    for direction in (np.cross(normal, along), normal):
        height = (rise * direction).sum(axis=1)
        zigzag = height - 0.5 * (np.roll(height, 1) + np.roll(height, -1))
        sizes.append(float(np.median(np.abs(zigzag) / half)))
    inside, across = sizes
    return float(np.sqrt(inside**2 - across**2)) if inside > MIN_ZIGZAG_NOISE_RATIO * across else 0.0
