"""Count the independent observations in a misfit over a garment: those of neighbours are correlated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class CorrelationSettings:
    """Describe over which pairs of places a misfit's correlation is averaged.

    Attributes:
        distance: Largest distance of a pair [m]: half a torso. Few misfits are correlated over more.
        bin_width: Width of the classes of distance [m], less than half a fold; rho is interpolated where none is known.
        samples: Largest number of places that are compared: 3 cm apart on a garment of 1 m2, and 100 000 pairs.
        cosine: Smallest cosine between normals of neighbours on the cloth, not on two sides of a fold.
    """

    distance: float = 0.25
    bin_width: float = 0.01
    samples: int = 1000
    cosine: float = 0.3


def count_independent(
    places: np.ndarray,
    normals: np.ndarray,
    misfit: np.ndarray,
    areas: np.ndarray,
    settings: CorrelationSettings = CorrelationSettings(),
) -> float:
    """Return the number of independent observations in a misfit over cloth: the degrees of freedom of its mean square.

        n = A / int_0^R rho(s)^2 2 pi s ds,    rho(s) = <m_i m_j> / <m_i^2> over pairs at distance s
    A mean square L over A then scatters by sqrt(2 / n) of itself (Bayley and Hammersley, Journal of the Royal
    Statistical Society 8, 1946; Bretherton et al., Journal of Climate 12, 1999).

    Notation: A sum of `areas`; m `misfit`; R `distance`; averages by area, binned.

    Args:
        places: Points of the cloth [m], shape [n, 3].
        normals: Unit normals there, shape [n, 3].
        misfit: Misfit at each [m], shape [n].
        areas: Of the cloth around each [m2], shape [n].
        settings: Which pairs are compared.
    """
    size = float((areas * misfit**2).sum() / areas.sum())
    if size == 0.0:
        return float(len(places))
    picked = np.linspace(0, len(places) - 1, min(settings.samples, len(places))).astype(np.int64)
    i, j = picked[cKDTree(places[picked]).query_pairs(settings.distance, output_type="ndarray").T]
    is_alike = (normals[i] * normals[j]).sum(1) > settings.cosine
    i, j, width = i[is_alike], j[is_alike], settings.bin_width
    apart, bins = np.linalg.norm(places[i] - places[j], axis=1), settings.distance / width
    kind = np.minimum(apart / width, bins - 1).astype(np.int64)
    weight, count = areas[i] * areas[j], round(bins)
    total = np.bincount(kind, weight, count)
    product = np.bincount(kind, weight * misfit[i] * misfit[j], count)
    known, middle = total > 0.0, width * (np.arange(count) + 0.5)
    found = np.clip(product[known] / total[known] / size, -1.0, 1.0)
    alike = np.interp(middle, np.append(0.0, middle[known]), np.append(1.0, found))
    return float(areas.sum() / (alike**2 * 2.0 * np.pi * middle * width).sum())
