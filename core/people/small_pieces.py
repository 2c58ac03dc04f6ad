"""Relabel pieces of a part that are too small by the labels around them, and pieces of a garment beyond bare skin."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.connectivity import find_components
from .diffusion import Links
from .limbs import BodyPlace, Limb
from .part import GARMENTS, PARTS, Part

LIMBS = (Limb.LEFT_ARM, Limb.RIGHT_ARM, Limb.LEFT_LEG, Limb.RIGHT_LEG)
"""What a garment reaches from the trunk."""

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


def relabel_beyond_skin(column: np.ndarray, posterior: np.ndarray, place: BodyPlace, links: Links) -> np.ndarray:
    """Return the labels without pieces of garments on a limb that bare skin separates from the trunk.

    A garment is one piece, the largest. What has its colour further out, a boot or a sock, becomes the likeliest of
    what is no garment. What another garment, hair or a gap of the scan separates may belong to it.

    Args:
        column: Index in `PARTS` of each sample, shape [n].
        posterior: Of the parts, shape [n, part_count].
        place: Where on the body the samples are.
        links: Neighbours, which connect pieces.
    """
    same = links.pairs[column[links.pairs[:, 0]] == column[links.pairs[:, 1]]]
    count, piece = find_components(links.count, same[:, 0], same[:, 1])
    kind = np.zeros(count, dtype=np.int64)
    kind[piece] = column
    is_limb = np.isin(place.limb, LIMBS)
    size = np.bincount(piece, minlength=count)
    on_limb = np.bincount(piece, is_limb, count) > 0.5 * size
    is_main = size == np.array([size[kind == one].max(initial=0) for one in range(len(PARTS))])[kind]
    first = np.full(count, np.inf)
    np.minimum.at(first, piece, place.station)
    inner, skin = np.zeros(count), np.zeros(count)
    for a, b in (links.pairs.T, links.pairs.T[::-1]):
        inward = (piece[a] != piece[b]) & (place.station[b] < first[piece[a]])
        inner += np.bincount(piece[a[inward]], minlength=count)
        is_skin = inward & (column[b] == PARTS.index(Part.SKIN))
        skin += np.bincount(piece[a[is_skin]], minlength=count)
    is_garment = np.isin(kind, [PARTS.index(part) for part in GARMENTS])
    beyond = (is_garment & on_limb & ~is_main & (skin > 0.5 * inner))[piece]
    others = np.where(np.isin(PARTS, GARMENTS), -1.0, posterior)
    return np.where(beyond, others.argmax(axis=1), column)


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
