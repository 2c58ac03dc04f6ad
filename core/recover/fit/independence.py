"""Count the independent observations in a misfit over a garment: those of neighbours are correlated."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

MAX_CORRELATION_DISTANCE = 0.25
"""Largest distance at which places are compared [m]: half a torso. Few misfits are correlated over more."""

CORRELATION_BIN_WIDTH = 0.01
"""Width of the classes of distance [m]: less than half a fold. Between classes with pairs, rho is interpolated."""

MAX_CORRELATION_SAMPLE_COUNT = 1000
"""Largest number of places that are compared: 3 cm apart on a garment of 1 m2, and 100 000 pairs."""

MIN_NEIGHBOUR_COSINE = 0.3
"""Smallest cosine between two normals at which their places are neighbours on the cloth, not two sides of a fold."""


def count_independent(places: np.ndarray, normals: np.ndarray, misfit: np.ndarray, areas: np.ndarray) -> float:
    """Return the number of independent observations in a misfit over cloth: the degrees of freedom of its mean square.

        n = A / int_0^R rho(s)^2 2 pi s ds,    rho(s) = <m_i m_j> / <m_i^2> over pairs at distance s
    A mean square L over A then scatters by sqrt(2 / n) of itself (Bayley and Hammersley, Journal of the Royal
    Statistical Society 8, 1946; Bretherton et al., Journal of Climate 12, 1999).

    Notation: A sum of `areas`; m `misfit`; R `MAX_CORRELATION_DISTANCE`; averages by area, binned.

    Args:
        places: Points of the cloth [m], shape [n, 3].
        normals: Unit normals there, shape [n, 3].
        misfit: Misfit at each [m], shape [n].
        areas: Of the cloth around each [m2], shape [n].
    """
    size = float((areas * misfit**2).sum() / areas.sum())
    if size == 0.0:
        return float(len(places))
    picked = np.linspace(0, len(places) - 1, min(MAX_CORRELATION_SAMPLE_COUNT, len(places))).astype(np.int64)
    i, j = picked[cKDTree(places[picked]).query_pairs(MAX_CORRELATION_DISTANCE, output_type="ndarray").T]
    is_alike = (normals[i] * normals[j]).sum(1) > MIN_NEIGHBOUR_COSINE
    i, j = i[is_alike], j[is_alike]
    kind = np.minimum(
        np.linalg.norm(places[i] - places[j], axis=1) / CORRELATION_BIN_WIDTH,
        MAX_CORRELATION_DISTANCE / CORRELATION_BIN_WIDTH - 1,
    ).astype(np.int64)
    weight, count = areas[i] * areas[j], round(MAX_CORRELATION_DISTANCE / CORRELATION_BIN_WIDTH)
    total = np.bincount(kind, weight, count)
    product = np.bincount(kind, weight * misfit[i] * misfit[j], count)
    known, middle = total > 0.0, CORRELATION_BIN_WIDTH * (np.arange(count) + 0.5)
    found = np.clip(product[known] / total[known] / size, -1.0, 1.0)
    alike = np.interp(middle, np.append(0.0, middle[known]), np.append(1.0, found))
    return float(areas.sum() / (alike**2 * 2.0 * np.pi * middle * CORRELATION_BIN_WIDTH).sum())
