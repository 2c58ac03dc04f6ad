"""Find colours that show a scan's geometry, or nothing, and not its surface."""

from __future__ import annotations

import numpy as np

MIN_EXPLAINED_BY_NORMALS = 0.6
"""Share of each channel's variance that a quadratic of the normal explains, from which on colours show normals: 0.81 to
0.98 of two reconstructions that are coloured so, in front and behind or behind only; 0.25 at most of photographs."""

MIN_EXPLAINED_BY_HEIGHT = 0.99
"""Share of each channel's variance between thin slices, from which on colours show the place along an axis. Clothes of
one colour each leave the hands beside the trousers."""

SLICE_COUNT = 64
"""Number of slices along an axis: 3 cm of a person, of which a colour map crosses few shades."""

MIN_COLOUR_STD = 2.0 / 255.0
"""Standard deviation of every channel [1] below which a surface has one colour: two steps of a byte."""

JUDGED_COLOUR_COUNT = 20_000
"""Number of points on which colours are judged, at regular steps."""


def find_shown_geometry(points: np.ndarray, normals: np.ndarray | None, colours: np.ndarray) -> str | None:
    """Return what colours show that is not the surface's own colour, or None.

    Args:
        points: Positions [m], y up, shape [n, 3].
        normals: Outward unit normals, shape [n, 3], or None where their sides are not known.
        colours: RGB in 0..1, shape [n, 3].

    Returns:
        `one colour`, `the place along an axis` or `the directions of the surface`.
    """
    step = max(1, len(points) // JUDGED_COLOUR_COUNT)
    points, colours = points[::step], colours[::step]
    if (colours.std(axis=0) < MIN_COLOUR_STD).all():
        return "one colour"
    if any(_explained_by_slices(points[:, axis], colours) >= MIN_EXPLAINED_BY_HEIGHT for axis in range(3)):
        return "the place along an axis"
    if normals is None:
        return None
    normals = normals[::step]
    for side in (normals[:, 2] > 0.0, normals[:, 2] <= 0.0, normals[:, 0] > 0.0, normals[:, 0] <= 0.0):
        if _explained_by_normals(normals[side], colours[side]) >= MIN_EXPLAINED_BY_NORMALS:
            return "the directions of the surface"
    return None


def _explained_by_normals(normals: np.ndarray, colours: np.ndarray) -> float:
    """Return the share of the variance that a quadratic of the normal explains, of the channel with the least."""
    x, y, z = normals.T
    terms = np.stack([np.ones_like(x), x, y, z, x * x, y * y, x * y, y * z, z * x], axis=1)
    if len(terms) <= terms.shape[1]:
        return 0.0
    fitted = terms @ np.linalg.lstsq(terms, colours, rcond=None)[0]
    return _least_share(colours, ((colours - fitted) ** 2).mean(axis=0))


def _explained_by_slices(place: np.ndarray, colours: np.ndarray) -> float:
    """Return the share of the variance that is between slices along an axis, of the channel with the least."""
    low, high = float(place.min()), float(place.max())
    at = np.minimum(((place - low) / max(high - low, 1e-12) * SLICE_COUNT).astype(np.int64), SLICE_COUNT - 1)
    count = np.maximum(np.bincount(at, minlength=SLICE_COUNT), 1)
    means = np.stack([np.bincount(at, channel, SLICE_COUNT) / count for channel in colours.T], axis=1)
    return _least_share(colours, ((colours - means[at]) ** 2).mean(axis=0))


def _least_share(colours: np.ndarray, left: np.ndarray) -> float:
    """Return the least share of the variance that is explained, given what is left of it, of channels that vary."""
    varies = colours.std(axis=0) >= MIN_COLOUR_STD
    if not varies.any():
        return 0.0
    return float((1.0 - left[varies] / colours.var(axis=0)[varies]).min())
