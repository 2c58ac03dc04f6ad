"""Holes that have broken through a contour: found by their narrow mouth and bridged there."""

from __future__ import annotations

import numpy as np

NARROW = 2.5
"""A bite's rim is at least so many times its mouth. A half-round scallop has 1.6 and a pointed V-neck 2: design."""
SHALLOW = 0.05
"""A bite reaches into the garment by at least this much [m]; less is a tooth of a cut along triangles."""
DEEP = 0.25
"""A bite reaches into the garment by at least this share of its rim; a fold of a hem runs sideways instead."""
FINEST = 1000
"""Points compared in pairs; a longer contour is searched at every second, third, ... point."""
TRIED = 500
"""Stretches looked at, narrowest first; the folds of a gathered hem are many, and all of them are turned down."""


def bridge_bites(points: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Cut bites off a contour along the chord of their mouth.

    Of all stretches of the contour that are much longer than the chord between their ends, and that reach into the
    garment (along the contour's area vector), the one with the narrowest mouth for its length is cut off, then
    again.

    Args:
        points: The contour [m], garment on the left, shape [n, 3].

    Returns:
        Indices of the points that stay on the contour, in order, and those of each bite, its mouth's two ends included.
    """
    kept = np.arange(len(points))
    bites: list[np.ndarray] = []
    while len(kept) > 8 and (bite := _find_bite(points[kept])) is not None:
        start, count = bite
        kept = np.roll(kept, -start)
        bites.append(kept[: count + 1])
        kept = np.concatenate([kept[:1], kept[count:]])
    return kept, tuple(bites)


def _find_bite(points: np.ndarray) -> tuple[int, int] | None:
    """Find the start of the bite with the narrowest mouth and its number of steps, or None."""
    stride = -(-len(points) // FINEST)
    found = _search_pairs(points[::stride])
    if found is None:
        return None
    start, count = found[0] * stride, found[1] * stride
    return start, min(count, len(points) - 2)


def _search_pairs(points: np.ndarray) -> tuple[int, int] | None:
    count = len(points)
    steps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.concatenate([steps, steps]))])
    start, span = np.meshgrid(np.arange(count), np.arange(2, count // 2), indexing="ij")
    length = arc[start + span] - arc[start]
    chord = np.linalg.norm(points[(start + span) % count] - points[start], axis=2)
    narrow = (length >= 2.0 * SHALLOW) & (length > NARROW * chord) & (length < 0.5 * arc[count])
    if not narrow.any():
        return None
    area = 0.5 * np.cross(points - points.mean(axis=0), np.roll(points, -1, axis=0) - points.mean(axis=0)).sum(axis=0)
    normal = area / max(float(np.linalg.norm(area)), 1e-12)
    candidates = np.argwhere(narrow)
    narrowness = (length / np.maximum(chord, 1e-9))[narrow]
    for row, column in candidates[np.argsort(-narrowness, kind="stable")][:TRIED].tolist():
        first, steps_taken = row, column + 2
        inside = points[(first + np.arange(1, steps_taken)) % count] - points[first]
        if float((inside @ normal).max()) >= max(SHALLOW, DEEP * float(length[row, column])):
            return first, steps_taken
    return None
