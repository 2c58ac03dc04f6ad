"""Relabel pieces of a part that are too small by the labels around them."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.connectivity import find_components
from .diffusion import Links

MIN_LABEL_PIECE_AREA = 15e-4
"""Area below which a connected piece of one label is relabelled [m2]: the back of a hand has 80 cm2, a toddler's shoe
100; a pocket or a knee that is labelled wrongly has less."""


def relabel_small_pieces(column: np.ndarray, points: np.ndarray, area: np.ndarray, links: Links) -> np.ndarray:
    """Return the labels with each piece below `MIN_LABEL_PIECE_AREA` changed to the label most frequent around it.

    Args:
        column: Label of each point, any integers, shape [n].
        points: Positions [m], shape [n, 3].
        area: That each point represents [m2], shape [n].
        links: Neighbours, which connect pieces.
    """
    column = column.copy()
    for _ in range(len(points)):
        same = links.pairs[column[links.pairs[:, 0]] == column[links.pairs[:, 1]]]
        count, piece = find_components(links.count, same[:, 0], same[:, 1])
        size = np.bincount(piece, area, count)
        small = size < MIN_LABEL_PIECE_AREA
        if not small.any() or small.all():
            break
        labels = _relabel_by_neighbours(column, points, piece, small, links)
        if (labels == column).all():
            break
        column = labels
    return column


def _relabel_by_neighbours(
    column: np.ndarray, points: np.ndarray, piece: np.ndarray, small: np.ndarray, links: Links
) -> np.ndarray:
    """Return labels with each small piece's taken from the large pieces that it touches, or else the nearest."""
    inside = small[piece]
    votes = np.zeros((len(small), int(column.max()) + 1))
    for a, b in (links.pairs.T, links.pairs.T[::-1]):
        border = inside[a] & ~inside[b]
        np.add.at(votes, (piece[a[border]], column[b[border]]), 1.0)
    touched = votes.sum(axis=1) > 0.0
    labels = np.where(inside & touched[piece], votes.argmax(axis=1)[piece], column)
    alone = np.flatnonzero(inside & ~touched[piece])
    large = np.flatnonzero(~inside)
    if len(alone):
        labels[alone] = column[large[cKDTree(points[large]).query(points[alone])[1]]]
    return np.asarray(labels)
