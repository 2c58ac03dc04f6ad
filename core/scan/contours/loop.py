"""Find open boundaries of a mesh: ordered loops, their length, and the disk that spans one."""

from __future__ import annotations

import numpy as np

from ...geometry.connectivity import HalfEdges
from ...geometry.curves import Curve

CONTOUR_SMOOTHING_LENGTH = 0.03
"""Width over which a contour is smoothed before it is measured [m]: wider than the teeth of a cut along a scan's
triangles (1 cm), narrower than any feature of a contour's design."""
LOOP_SAMPLE_SPACING = 0.004
"""Spacing of the samples of a loop [m]: several in one smoothing width."""
MIN_SMOOTHED_LENGTH_SHARE = 0.8
"""Share of its own length of a smoothed curve below which it was cut along triangles; a wavy hem keeps more."""


def find_loops(faces: np.ndarray, vertices: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    """Find the boundary loops of a surface, each in order with the surface on its left.

    A loop continues from a boundary edge to the next by turning through the faces around the edge's end. A loop that
    returns to a vertex (a pinched vertex: two holes that touch) is split there into simple loops. With `vertices`
    positions are compared instead of indices, so that loops are also split where a pinched vertex is doubled.

    Args:
        faces: Consistently oriented faces, shape [face_count, 3].
        vertices: Positions, shape [vertex_count, 3], or None.

    Returns:
        Vertex indices of each loop, int64, without the first one repeated; longest loop (by count) first.
    """
    faces = np.asarray(faces, dtype=np.int64)
    if len(faces) == 0:
        return ()
    edges = HalfEdges.of(faces)
    tail, twin, following = edges.tail, edges.twin, edges.following
    key = np.arange(edges.vertex_count)
    if vertices is not None:
        key = np.unique(np.asarray(vertices), axis=0, return_inverse=True)[1].ravel()
    rims = np.flatnonzero(twin < 0)
    left = set(rims.tolist())
    loops: list[np.ndarray] = []
    for start in rims.tolist():
        if start not in left:
            continue
        path: list[int] = []
        edge = start
        while edge in left:
            left.discard(edge)
            path.append(int(tail[edge]))
            edge = int(following[edge])
            while twin[edge] >= 0:
                edge = int(following[twin[edge]])
        loops += [np.array(loop, np.int64) for loop in _split_at_repeats(path, key) if len(loop) >= 3]
    return tuple(sorted(loops, key=lambda loop: (-len(loop), int(loop[0]))))


def _split_at_repeats(path: list[int], key: np.ndarray) -> list[list[int]]:
    """Split a closed walk into simple loops wherever it returns to an earlier place."""
    loops: list[list[int]] = []
    stack: list[int] = []
    place: dict[int, int] = {}
    for vertex in path:
        current = int(key[vertex])
        if current in place:
            since = place[current]
            loops.append(stack[since:])
            for removed in stack[since:]:
                del place[int(key[removed])]
            del stack[since:]
        place[current] = len(stack)
        stack.append(vertex)
    return [*loops, stack]


def smooth_loop(points: np.ndarray, width: float = CONTOUR_SMOOTHING_LENGTH) -> np.ndarray:
    """Smooth a closed polygon along its arc by a triangular window of `width` [m] in all, shape [sample_count, 3].

    The window is applied to the Fourier series of the resampled curve: the harmonic of period p is multiplied by
    sinc(width / 2p) squared. A circle of radius R shrinks by (width / R)^2 / 48: 0.3 % for a cuff.
    """
    polygon = Curve(points)
    length = polygon.length
    if length == 0.0:
        return points
    count = max(16, 2 * round(length / LOOP_SAMPLE_SPACING / 2))
    series = np.fft.rfft(polygon.resample(count), axis=0)
    frequency = np.arange(len(series)) / length
    return np.fft.irfft(series * np.sinc(0.5 * width * frequency)[:, None] ** 2, count, axis=0)


def smooth_ragged_loop(points: np.ndarray, width: float = CONTOUR_SMOOTHING_LENGTH) -> np.ndarray:
    """Smooth a closed polygon, shape [n, 3], over `width` [m] as `smooth_loop`, shape [sample_count, 3].

    If that removes a fifth of the length it is smoothed again: on a ragged curve's long arc the width was too small.
    """
    curve = smooth_loop(np.asarray(points, dtype=np.float64), width)
    ragged = Curve(curve).length < MIN_SMOOTHED_LENGTH_SHARE * Curve(points).length
    return smooth_loop(curve, width) if ragged else curve


def smoothed_length(points: np.ndarray, width: float = CONTOUR_SMOOTHING_LENGTH) -> float:
    """Return the length [m] of a closed polygon, shape [n, 3], smoothed over `width` [m] (`smooth_ragged_loop`)."""
    return Curve(smooth_ragged_loop(points, width)).length


def span_disk(points: np.ndarray, *, around: int = 64, rings: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """Span a smoothed closed curve by a harmonic disk; return its vertices [m] and faces.

    X(r, t) = sum_k c_k r^|k| exp(i k t), with c_k the Fourier series of the curve over its arc length t: each
    coordinate is harmonic, so the disk has no folds that the curve does not force and is close to the minimal surface.

    Args:
        points: The curve, shape [n, 3].
        around: Number of points along the curve; 64 keep a 1.5 m hem within 2.5 cm steps.
        rings: Number of circles from the curve to the centre.
    """
    series = np.fft.fft(Curve(points).resample(around), axis=0)
    order = np.abs(np.fft.fftfreq(around, 1.0 / around))
    radii = np.arange(rings, 0, -1) / rings
    circles = [np.fft.ifft(series * (radius**order)[:, None], axis=0).real for radius in radii]
    vertices = np.concatenate([*circles, series[:1].real / around])
    ring, step = np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij")
    a, b = ring * around + step, ring * around + (step + 1) % around
    c, d = a + around, b + around
    quads = np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)
    last = (rings - 1) * around + np.arange(around)
    cap = np.stack([last, np.roll(last, -1), np.full(around, rings * around)], axis=1)
    return vertices, np.concatenate([quads, cap])
