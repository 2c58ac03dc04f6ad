"""Fill the gaps of a texture from their surroundings."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import distance_transform_edt


def fill_gaps(image: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Fill unknown texels smoothly from known ones, by averages over ever larger blocks (pull) and back (push).

    Source: Gortler, Grzeszczuk, Szeliski, Cohen, "The Lumigraph", SIGGRAPH 1996, section 3.4 (pull and push).
    **Deviation**: blocks of 2 x 2 instead of a wider filter, and a block with any known texel counts as known.

    Args:
        image: Values, shape [height, width, channels].
        known: Which texels are known, shape [height, width].

    Returns:
        The image, known texels unchanged; unchanged at all where none is known.
    """
    if known.all() or not known.any():
        return image.copy()
    height, width = known.shape
    padded = np.zeros((height + height % 2, width + width % 2, image.shape[2]))
    weight = np.zeros(padded.shape[:2])
    padded[:height, :width] = image * known[..., None]
    weight[:height, :width] = known
    blocks = _sum_blocks(weight)
    coarse = _sum_blocks(padded) / np.maximum(blocks, 1.0)[..., None]
    larger = _enlarge(fill_gaps(coarse, blocks > 0.0), height, width)
    return np.asarray(np.where(known[..., None], image, larger))


def spread_border(image: np.ndarray, cloth: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return an image in which each texel near the cloth has the nearest cloth's colour, and which texels are near.

    Args:
        image: Values, shape [height, width, channels].
        cloth: Which texels are cloth, shape [height, width].
        width: Distance from the cloth up to which texels are near [texel].
    """
    if not cloth.any():
        return image, cloth
    distance, (row, column) = distance_transform_edt(~cloth, return_indices=True)
    return image[row, column], distance <= width


def _sum_blocks(values: np.ndarray) -> np.ndarray:
    return np.asarray(values[::2, ::2] + values[1::2, ::2] + values[::2, 1::2] + values[1::2, 1::2])


def _enlarge(coarse: np.ndarray, height: int, width: int) -> np.ndarray:
    """Enlarge an image twofold by bilinear weights 3/4 and 1/4, shape [height, width, channels]."""
    for axis, length in ((0, height), (1, width)):
        last = coarse.shape[axis] - 1
        place = (np.arange(length) - 0.5) / 2.0
        lower = np.clip(np.floor(place), 0, last).astype(np.int64)
        upper = np.minimum(lower + 1, last)
        share = np.clip(place - lower, 0.0, 1.0).reshape([-1 if k == axis else 1 for k in range(3)])
        coarse = (1.0 - share) * np.take(coarse, lower, axis) + share * np.take(coarse, upper, axis)
    return coarse
