"""Estimate a scan's noise from its roughness, and smooth it by as much as leaves the least error."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import edge_lengths, vertex_normals

MIN_SCAN_NOISE_STD = 4e-3
"""Noise from which a scan is smoothed first [m per coordinate]. Below, the garment's own edges average it out (2 mm
gave 1.1 mm); clean garments of 3 to 8 thousand vertices show 0.9 to 1.8 mm, which are folds. With smoothing 5 mm gave
1.7 mm to the truth, without 2.6."""

MIN_ROUGHNESS_RATIO = 0.35
"""Least ratio of noise's roughness to the edge length: a coarse but clean mesh has 0.14 to 0.2, one with 5 mm of noise
on edges of 14 to 20 mm 0.38 to 0.5."""

ROUGH_OF_NOISE = 1.66
"""Ratio of a vertex's median distance from its ring's mean to the noise: 1.54 (median of chi, 3 degrees) sqrt(7/6)."""

MIN_DENOISING_WEIGHT, MAX_DENOISING_WEIGHT = 1.0, 1e4
"""Weights of smoothing, least and largest, relative to the distance from the scan: 1 removes half the noise of an even
mesh, and 10 000 half the depth of a fold 30 edges long, 40 cm on a garment's."""

TRACE_PROBE_COUNT = 4
"""Number of random vectors in the estimate of the trace: at 4 thousand vertices one alone is within 2 %."""


def smooth_noise(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, float]:
    """Smooth a surface whose noise is larger than what the garment's edges average out.

    The noise is sigma = median |L x| / `ROUGH_OF_NOISE`, where L x is a vertex's distance from the mean of its ring.
    The smoothed surface is A y with A = (I + s L^T L)^-1: on an even mesh a fold of w edges keeps
    1 / (1 + s (pi / w)^4) of its depth. On a border L runs along the border, so that openings do not shrink. s
    minimises Stein's unbiased estimate of the error that is left across the surface (C. Stein, "Estimation of the mean
    of a multivariate normal distribution", Annals of Statistics 9, 1981),

        R(s) = sum_i (n_i . (A y - y)_i)^2 + 2 sigma^2 tr A,    up to a constant,

    with the normals n of the smoothed surface: errors along it change no shape. The trace is estimated with
    `TRACE_PROBE_COUNT` vectors (Hutchinson's estimator).

    Returns:
        The vertices [m], and the noise [m per coordinate], 0 where nothing was smoothed.
    """
    rings, edges = _ring_means(vertices, faces)
    laplacian = (sp.identity(len(vertices), format="csr") - rings).tocsr()
    length = float(np.median(edge_lengths(vertices, edges)))
    rough = float(np.median(np.linalg.norm(laplacian @ vertices, axis=1)))
    noise = rough / ROUGH_OF_NOISE
    if noise < MIN_SCAN_NOISE_STD or rough < MIN_ROUGHNESS_RATIO * length:
        return vertices, 0.0
    from scipy.optimize import minimize_scalar  # most scans are not noisy, and each check of a file would import it

    square = (laplacian.T @ laplacian).tocsr()
    probes = np.random.default_rng(0).choice([-1.0, 1.0], size=(len(vertices), TRACE_PROBE_COUNT))

    def risk(exponent: float) -> float:
        smooth, echo = np.hsplit(_smooth(square, float(np.exp(exponent)), np.hstack([vertices, probes])), [3])
        trace = float((probes * echo).sum()) / TRACE_PROBE_COUNT
        across = ((smooth - vertices) * vertex_normals(smooth, faces)).sum(axis=1)
        return float(across @ across) + 2.0 * noise**2 * trace

    # A tenth of the exponent is a tenth of the weight: the risk is flat there.
    best = minimize_scalar(
        risk,
        bounds=(np.log(MIN_DENOISING_WEIGHT), np.log(MAX_DENOISING_WEIGHT)),
        method="bounded",
        options={"xatol": 0.1},
    )
    return _smooth(square, float(np.exp(best.x)), vertices), noise


def _smooth(square: sp.csr_matrix, weight: float, values: np.ndarray) -> np.ndarray:
    """Solve (I + weight square) smooth = values, column by column; some 50 products with the matrix each."""
    system = sp.identity(len(values), format="csr") + weight * square
    return np.column_stack([spla.cg(system, column, x0=column, rtol=1e-6)[0] for column in values.T])


def _ring_means(vertices: np.ndarray, faces: np.ndarray) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return the matrix that maps vertices to the mean of their ring, at a border along the border; and the edges."""
    count = len(vertices)
    half_edges = HalfEdges.of(faces, count)
    edges, border = half_edges.edges, half_edges.border_vertices
    rim = edges[half_edges.face_counts == 1]
    links = np.concatenate([edges, edges[:, ::-1]])
    links = np.concatenate([links[~border[links[:, 0]]], rim, rim[:, ::-1]])
    graph = sp.csr_matrix((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    degree = np.asarray(graph.sum(axis=1)).ravel()
    alone = sp.diags((degree == 0).astype(np.float64))
    return (sp.diags(1.0 / np.maximum(degree, 1.0)) @ graph + alone).tocsr(), edges
