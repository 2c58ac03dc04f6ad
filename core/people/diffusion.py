"""Smooth posteriors over neighbouring points, but not across steps and changes of colour."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, diags, identity
from scipy.spatial import cKDTree

from ..geometry.linear import Factor, factor_symmetric

LINK_NEIGHBOUR_COUNT = 8
"""Number of neighbours that each point is linked with: about the ring of a triangulation."""

MAX_LINK_LENGTH = 0.02
"""Largest length of a link [m]: samples are 7 mm apart, and across a hole 2 cm wide the cloth is still the same."""

MIN_LINK_NORMAL_COSINE = 0.3
"""Least cosine between the normals of linked points: an arm beside the trunk and the inside of a sleeve face away."""

DIFFUSION_STRENGTH = 4.0
"""Weight of differences between neighbours relative to the points' own evidence: at 4, 40 % wrong points of a patch of
40K become 1 %, and a border between two parts is 4 samples, 3 cm, wide before the labels sharpen it."""


@dataclass(frozen=True)
class Links:
    """Describe which points are neighbours, and the weight of each link.

    Attributes:
        pairs: Indices of two points, each pair once, int64, shape [link_count, 2].
        weight: In 0..1, shape [link_count].
        count: Number of points.
        by_colour: The same, weakened where colours change; None without colours.
    """

    pairs: np.ndarray
    weight: np.ndarray
    count: int
    by_colour: Links | None = None

    @cached_property
    def factor(self) -> Factor:
        """Return the factors of I + `DIFFUSION_STRENGTH` L: 0.1 s for a person's samples, solving a hundredth of it."""
        return factor_symmetric((identity(self.count) + DIFFUSION_STRENGTH * self.laplacian()).tocsc())

    def laplacian(self) -> coo_matrix:
        """Return L = D - W, shape [count, count]."""
        i, j = self.pairs.T
        both = (np.concatenate([i, j]), np.concatenate([j, i]))
        links = coo_matrix((np.tile(self.weight, 2), both), shape=(self.count, self.count)).tocsr()
        return diags(np.asarray(links.sum(axis=1)).ravel()) - links

    def weakened(self, values: np.ndarray, scale: float) -> Links:
        """Return the links weighted by exp(-|difference|^2 / 2 scale^2) of values, shape [count] or [count, k]."""
        step = values[self.pairs[:, 0]] - values[self.pairs[:, 1]]
        square = step**2 if step.ndim == 1 else (step**2).sum(axis=1)
        return Links(self.pairs, self.weight * np.exp(-0.5 * square / scale**2), self.count)


def link_points(
    points: np.ndarray, normals: np.ndarray, neighbours: int = LINK_NEIGHBOUR_COUNT, reach: float = MAX_LINK_LENGTH
) -> Links:
    """Link each point with its nearest neighbours on the same sheet.

    Args:
        points: Positions [m], shape [n, 3].
        normals: Unit normals, outward, shape [n, 3].
        neighbours: How many.
        reach: Longest link [m].
    """
    distance, neighbour = cKDTree(points).query(points, neighbours + 1, distance_upper_bound=reach)
    origin = np.repeat(np.arange(len(points)), neighbours)
    other, found = neighbour[:, 1:].ravel(), np.isfinite(distance[:, 1:]).ravel()
    pairs = np.sort(np.stack([origin[found], other[found]], axis=1), axis=1)
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    facing = (normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(axis=1)
    pairs = pairs[facing > MIN_LINK_NORMAL_COSINE]
    return Links(pairs, np.ones(len(pairs)), len(points))


def diffuse(posterior: np.ndarray, links: Links) -> np.ndarray:
    """Return the posterior smoothed over the links, shape [n, k]: the u that minimises

        sum_i |u_i - p_i|^2 + s sum_ij w_ij |u_i - u_j|^2,  s = `DIFFUSION_STRENGTH`.

    It solves (I + s L) u = p and is a posterior again: rows are in 0..1 and sum to 1, since the matrix is an M-matrix
    with row sums of 1. (Screened diffusion; random walker segmentation with priors, Grady 2005.)

    Args:
        posterior: Probability of each part, shape [n, k].
        links: Neighbours; their factors are computed once.
    """
    smooth = np.maximum(links.factor.solve(np.ascontiguousarray(posterior)), 0.0)
    return np.asarray(smooth / smooth.sum(axis=1, keepdims=True))
