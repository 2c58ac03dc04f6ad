"""Distances between the open contours of two surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..segment import Contour, find_loops, resample_loop

CONTOUR_SAMPLES = 500
"""Points along each loop: 2 mm apart on a wide hem, far below what a contour error is judged by."""


def closest_on_loop(points: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Find the point of a closed polyline that is closest to each point [m], shape [point_count, dimension]."""
    step = np.roll(loop, -1, axis=0) - loop
    square = np.maximum(np.einsum("ij,ij->i", step, step), 1e-30)  # a segment without length is its start point
    along = (points @ step.T - np.einsum("ij,ij->i", loop, step)) / square
    foot = loop[None] + np.clip(along, 0.0, 1.0)[:, :, None] * step[None]
    gap = points[:, None] - foot
    nearest = np.argmin(np.einsum("pij,pij->pi", gap, gap), axis=1)
    return np.asarray(foot[np.arange(len(points)), nearest])


def distance_to_loop(points: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Measure the exact distance of each point to a closed polyline [m], shape [point_count]; any dimension."""
    return np.linalg.norm(points - closest_on_loop(points, loop), axis=1)


def loop_rms(first: np.ndarray, second: np.ndarray) -> float:
    """Measure the larger RMS distance [m] of two closed loops, from arc-length samples of each to the other."""
    forward = distance_to_loop(resample_loop(first, CONTOUR_SAMPLES), second)
    backward = distance_to_loop(resample_loop(second, CONTOUR_SAMPLES), first)
    return float(max(np.sqrt(np.mean(forward**2)), np.sqrt(np.mean(backward**2))))


def contour_rms(
    nodes: np.ndarray, contours: Sequence[Contour], truth_vertices: np.ndarray, truth_contours: Sequence[Contour]
) -> dict[str, float]:
    """Measure the RMS distance [m] of every trusted contour of the truth that ours has too, by name."""
    ours = {contour.name: nodes[contour.vertices] for contour in contours}
    return {
        contour.name: loop_rms(ours[contour.name], truth_vertices[contour.vertices])
        for contour in truth_contours
        if contour.trusted and contour.name in ours
    }


def carry_contours(
    contours: Sequence[Contour], positions: np.ndarray, vertices: np.ndarray, faces: np.ndarray
) -> tuple[Contour, ...]:
    """Find named contours on another mesh of the same surface: each goes to the boundary loop nearest to it.

    Args:
        contours: Named contours, indices into `positions`.
        positions: Vertices of the mesh that has the names [m], shape [n, 3].
        vertices: Vertices of the mesh that gets them [m], shape [m, 3].
        faces: Its faces, shape [face_count, 3].

    Returns:
        The contours with indices into `vertices`; untrusted ones too.
    """
    loops = find_loops(faces)
    carried = []
    for contour in contours:
        curve = positions[contour.vertices]
        if loops:
            nearest = min(loops, key=lambda loop: loop_rms(curve, vertices[loop]))
            carried.append(replace(contour, vertices=nearest))
    return tuple(carried)
