"""Distances between the open contours of two surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..segment import Contour

CONTOUR_SAMPLES = 500
"""Points along each loop: 2 mm apart on a wide hem, far below what a contour error is judged by."""


def resample_loop(loop: np.ndarray, count: int) -> np.ndarray:
    """Give points at equal arc length along a closed polyline [m], shape [count, dimension]."""
    closed = np.concatenate([loop, loop[:1]])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    wanted = np.arange(count) / count * arc[-1]
    return np.stack([np.interp(wanted, arc, closed[:, k]) for k in range(loop.shape[1])], axis=1)


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


def boundary_loops(faces: np.ndarray) -> list[np.ndarray]:
    """Trace the open boundary of a mesh into closed loops of vertex indices, the surface on the left."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    count = int(faces.max()) + 1 if len(faces) else 0
    forward = edges[:, 0] * count + edges[:, 1]
    open_edges = edges[~np.isin(forward, edges[:, 1] * count + edges[:, 0])]
    following: dict[int, list[int]] = {}
    for a, b in open_edges.tolist():
        following.setdefault(a, []).append(b)
    loops = []
    for start in sorted(following):
        while following[start]:
            loop, at = [start], following[start].pop()
            while at != start and following.get(at):
                loop.append(at)
                at = following[at].pop()
            if at == start and len(loop) > 2:
                loops.append(np.asarray(loop, dtype=np.int64))
    return loops


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
    loops = boundary_loops(faces)
    carried = []
    for contour in contours:
        curve = positions[contour.vertices]
        if loops:
            nearest = min(loops, key=lambda loop: loop_rms(curve, vertices[loop]))
            carried.append(replace(contour, vertices=nearest))
    return tuple(carried)
