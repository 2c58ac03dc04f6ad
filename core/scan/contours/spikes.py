"""Move a scan's outliers, single vertices far from their ring, back onto it."""

from __future__ import annotations

import numpy as np

from ...geometry.connectivity import HalfEdges, adjacency_matrix
from ...geometry.geometry import edge_lengths

SPIKE_EDGES = 1.3
"""Least distance of a spike from the median of its ring [median edges] (a trial found 113 of 115)."""

SPIKE_OWN = 0.7
"""Least distance of a spike, as a share of its own shortest edge: a coarse but sound patch has less."""

SPIKE_RING = 0.8
"""Quantile of its ring's distances from the ring's median that a spike exceeds: a sound vertex is within its ring,
however unevenly a scan was decimated. Not the maximum: one of the ring may be a spike itself."""


def flatten_spikes(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Move vertices far from the median of their ring onto it.

    A vertex is a spike when it is further from the component-wise median of its neighbours than `SPIKE_EDGES` median
    edges, than `SPIKE_OWN` of its own shortest edge and than most of these neighbours are (`SPIKE_RING`). On a border
    all neighbours are on one side, so there it is also that far from the middle of its two neighbours along the border:
    the corners of a coarse hem are none. Two rounds, because two spikes may be neighbours.

    Returns:
        The vertices [m] and which of them moved.
    """
    half_edges = HalfEdges.of(faces, len(vertices))
    edges, graph = half_edges.edges, half_edges.adjacency
    along = adjacency_matrix(edges[half_edges.face_counts == 1], len(vertices))
    degree = np.diff(graph.indptr)
    ring = np.full((len(vertices), max(int(degree.max(initial=0)), 1)), -1)
    ring[np.arange(ring.shape[1])[None] < degree[:, None]] = graph.indices
    used = np.flatnonzero(degree >= 3)
    ends = np.diff(along.indptr)[used]
    inner = ends == 0
    moved = np.zeros(len(vertices), dtype=bool)
    vertices = vertices.copy()
    length = float(np.median(edge_lengths(vertices, edges)))
    for _ in range(2):
        around = np.where((ring[used] >= 0)[..., None], vertices[ring[used]], np.nan)
        middle = np.nanmedian(around, axis=1)
        distance = np.nanmin(np.linalg.norm(around - vertices[used][:, None], axis=2), axis=1)
        off = np.linalg.norm(vertices[used] - middle, axis=1)
        reach = _quantiles(np.linalg.norm(around - middle[:, None], axis=2), degree[used], SPIKE_RING)
        beside = (along @ vertices)[used] / np.maximum(ends, 1)[:, None]
        bulge = np.where(inner, np.inf, np.linalg.norm(vertices[used] - beside, axis=1))
        spike = (np.minimum(off, bulge) > SPIKE_EDGES * length) & (off > SPIKE_OWN * distance) & (off > reach)
        vertices[used[spike]] = middle[spike]
        moved[used[spike]] = True
    return vertices, moved


def _quantiles(values: np.ndarray, counts: np.ndarray, share: float) -> np.ndarray:
    """Return a quantile of the first `counts` numbers of each row, the rest being NaN (linear, as in numpy)."""
    ordered, row = np.sort(values, axis=1), np.arange(len(values))
    at = share * (counts - 1)
    below = at.astype(np.int64)
    low, high = ordered[row, below], ordered[row, np.minimum(below + 1, counts - 1)]
    return np.asarray(low + (at - below) * (high - low))
