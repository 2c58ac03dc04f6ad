"""A scan's outliers and noise: a surface without the ones and most of the other."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

SPIKE_EDGES = 1.3
"""Distance from the median of its ring, in median edges, beyond which it is a spike (a trial found 113 of 115)."""

SPIKE_OWN = 0.7
"""A spike is also at least this share of its own shortest edge away: a coarse but sound patch is not."""

SPIKE_RING = 0.8
"""A spike also lies outside this quantile of its ring's distances from the ring's median: a sound vertex lies within
its ring, however unevenly a scan was decimated. Not the maximum: one of the ring may be a spike itself."""

NOISY = 4e-3
"""Noise of the scan [m per coordinate] from which it is smoothed first. Below, the garment's own edges average it out
(2 mm gave 1.1 mm); clean garments of 3 to 8 thousand vertices show 0.9 to 1.8 mm, folds. With smoothing 5 mm
gave 1.7 mm to the truth, without 2.6."""

ROUGH = 0.35
"""Roughness over edge length that noise has at least: a coarse but clean mesh has 0.14 to 0.2, one with 5 mm of noise
on edges of 14 to 20 mm 0.38 to 0.5."""

ROUGH_OF_NOISE = 1.66
"""Median distance of a vertex from the mean of its ring, over the noise: 1.54 (median of chi with three degrees) times
sqrt(1 + 1/6)."""

STIFF = 2.4e-8
"""Weight of the bilaplacian [m4] at 5 mm of noise; it grows with the noise. On two garments with edges of 14 mm the
distance to the truth was smallest there, for 5 mm (4.9 to 1.8 and 2.0 mm) as for 10 mm (9.4 to 3.0 and 2.9 mm)."""

FIRST = 10.0
"""Weight of the first smoothing, which only tells how long the edges are without the noise: about the same."""


def flatten_spikes(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Move vertices far from the median of their ring onto it.

    A vertex is a spike when it is further from the component-wise median of its neighbours than `SPIKE_EDGES` median
    edges, than `SPIKE_OWN` of its own shortest edge and than most of these neighbours are (`SPIKE_RING`). On a border
    all neighbours lie to one side, so there it is also that far from the middle of its two neighbours along the border:
    the corners of a coarse hem are none. Two rounds, because two spikes may be neighbours.

    Returns:
        The vertices [m] and which of them moved.
    """
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, uses = np.unique(sides, axis=0, return_counts=True)
    graph, along = _link(edges, len(vertices)), _link(edges[uses == 1], len(vertices))
    degree = np.diff(graph.indptr)
    ring = np.full((len(vertices), max(int(degree.max(initial=0)), 1)), -1)
    ring[np.arange(ring.shape[1])[None] < degree[:, None]] = graph.indices
    used = np.flatnonzero(degree >= 3)
    ends = np.diff(along.indptr)[used]
    inner = ends == 0
    moved = np.zeros(len(vertices), dtype=bool)
    vertices = vertices.copy()
    length = float(np.median(np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)))
    for _ in range(2):
        around = np.where((ring[used] >= 0)[..., None], vertices[ring[used]], np.nan)
        middle = np.nanmedian(around, axis=1)
        own = np.nanmin(np.linalg.norm(around - vertices[used][:, None], axis=2), axis=1)
        off = np.linalg.norm(vertices[used] - middle, axis=1)
        reach = _quantiles(np.linalg.norm(around - middle[:, None], axis=2), degree[used], SPIKE_RING)
        beside = (along @ vertices)[used] / np.maximum(ends, 1)[:, None]
        bulge = np.where(inner, np.inf, np.linalg.norm(vertices[used] - beside, axis=1))
        spike = (np.minimum(off, bulge) > SPIKE_EDGES * length) & (off > SPIKE_OWN * own) & (off > reach)
        vertices[used[spike]] = middle[spike]
        moved[used[spike]] = True
    return vertices, moved


def _quantiles(values: np.ndarray, counts: np.ndarray, share: float) -> np.ndarray:
    """Give a quantile of each row's first numbers, `counts` of them; what follows is no number (linear, as numpy's)."""
    ordered, row = np.sort(values, axis=1), np.arange(len(values))
    at = share * (counts - 1)
    below = at.astype(np.int64)
    low, high = ordered[row, below], ordered[row, np.minimum(below + 1, counts - 1)]
    return np.asarray(low + (at - below) * (high - low))


def _link(edges: np.ndarray, count: int) -> sp.csr_matrix:
    """Give the adjacency matrix of edges, shape [count, count]."""
    both = np.concatenate([edges, edges[:, ::-1]])
    return sp.csr_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(count, count))


def smooth_noise(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, float]:
    """Smooth a surface whose noise is larger than what the garment's edges average out.

    The noise is sigma = median |L x| / `ROUGH_OF_NOISE`, where L x is a vertex' distance from the mean of its ring. The
    smoothed surface solves (I + s L^2) x = x0 with s = 16 k / h^4: on an even mesh of edge h, L is -h^2/4 of the
    Laplacian, so that k is the weight of the bilaplacian, and a fold of wavelength w keeps 1 / (1 + k (2 pi / w)^4). On
    a border L runs along the border, so that openings do not shrink.

    Returns:
        The vertices [m], and the noise that was found [m per coordinate], 0 where nothing was smoothed.
    """
    rings, edges = _ring_means(vertices, faces)
    laplacian = sp.identity(len(vertices), format="csr") - rings
    length = float(np.median(np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)))
    rough = float(np.median(np.linalg.norm(laplacian @ vertices, axis=1)))
    noise = rough / ROUGH_OF_NOISE
    if noise < NOISY or rough < ROUGH * length:
        return vertices, 0.0
    square = laplacian @ laplacian
    identity = sp.identity(len(vertices), format="csr")
    # Noise lengthens the edges themselves: a first smoothing tells how long they are.
    once = spla.spsolve((identity + FIRST * square).tocsc(), vertices)
    length = float(np.median(np.linalg.norm(once[edges[:, 0]] - once[edges[:, 1]], axis=1)))
    weight = 16.0 * STIFF * (noise / 5e-3) / length**4
    return np.ascontiguousarray(spla.spsolve((identity + weight * square).tocsc(), vertices)), noise


def _ring_means(vertices: np.ndarray, faces: np.ndarray) -> tuple[sp.csr_matrix, np.ndarray]:
    """Give the matrix that takes each vertex to the mean of its ring, a border vertex' ring along the border; edges."""
    count = len(vertices)
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, uses = np.unique(sides, axis=0, return_counts=True)
    border = np.zeros(count, dtype=bool)
    rim = edges[uses == 1]
    border[rim.ravel()] = True
    links = np.concatenate([edges, edges[:, ::-1]])
    links = np.concatenate([links[~border[links[:, 0]]], rim, rim[:, ::-1]])
    graph = sp.csr_matrix((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    degree = np.asarray(graph.sum(axis=1)).ravel()
    alone = sp.diags((degree == 0).astype(np.float64))
    return (sp.diags(1.0 / np.maximum(degree, 1.0)) @ graph + alone).tocsr(), edges
