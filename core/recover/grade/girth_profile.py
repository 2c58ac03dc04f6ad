"""Compute girths along a garment within its surface, which a flat pattern and its drape have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...garment.garment import Garment
from ...geometry.connectivity import find_components
from ...geometry.geometry import cotangent_laplacian, face_areas, signed_areas
from ...geometry.linear import factor_symmetric
from ...scan.contours.target import Target

GIRTH_LEVEL_COUNT = 32
"""Number of places at which girths are taken: every 2 to 4 cm of a garment."""

GIRTH_LINE_COUNT = 4
"""Number of level lines over which each girth is averaged, which smooths the teeth of a coarse mesh."""

MIN_DOUBLE_FACE_AREA = 1e-12
"""Twice the area below which a face counts as degenerate [m2]: a needle of 2 cm and a twentieth of a nanometre."""

UPPER_CONTOURS, LOWER_CONTOURS = ("neck", "waist"), ("hem", "leg.left", "leg.right")
"""Contours at which a garment begins and ends; those of the arms are between."""

ARM_CONTOUR_STEMS = ("cuff", "armhole")
"""Stems of the contours of the arms."""


@dataclass(frozen=True)
class GirthProfile:
    """Describe a surface between two sets of its contours.

    Attributes:
        girths: Lengths of level lines of a harmonic function, 0 at one set, 1 at the other [m], [GIRTH_LEVEL_COUNT].
        distances: Of these lines from the first, along the surface and averaged along each [m], same shape.
        arms: Distance beyond which no line runs into a sleeve or ends at an armhole [m]; 0 where there are none.
    """

    girths: np.ndarray
    distances: np.ndarray
    arms: float = 0.0


def profile_target(target: Target) -> GirthProfile | None:
    """Measure a scan's garment; None without a trusted upper and lower end."""
    loops = {contour.name: contour.vertices for contour in target.contours if contour.trusted}
    return measure_girths(target.vertices[target.faces], target.faces, loops)


def profile_pattern(garment: Garment) -> GirthProfile | None:
    """Measure a sewn pattern by its flat triangles; its nodes are not used."""
    loops: dict[str, list[np.ndarray]] = {}
    for ref, line in garment.edge_uv.items():
        contour = garment.pattern.panel(ref.panel).edges[ref.edge].contour
        if contour:
            loops.setdefault(contour, []).append(garment.uv_node[line])
    return measure_girths(garment.rest, garment.faces, {name: np.concatenate(parts) for name, parts in loops.items()})


def measure_girths(corners: np.ndarray, faces: np.ndarray, loops: Mapping[str, np.ndarray]) -> GirthProfile | None:
    """Compute the girths of a surface from its upper contour to its lower ones; None where it has not both.

    Between two level lines of a harmonic function u the flow F = int |grad u|^2 dA is constant, so the line at u is on
    average ds = L(u) du / F beyond the previous one. Only the lengths of triangles' sides are used: a pattern and its
    drape have the same profile as far as the drape is isometric.

    Args:
        corners: The faces' corners, flat or in space [m], shape [face_count, 3, 2 or 3].
        faces: Node indices, shape [face_count, 3].
        loops: Nodes of the contours, by name.
    """
    start, end = (
        np.concatenate([loops[name] for name in names if name in loops] or [np.zeros(0, dtype=np.int64)])
        for names in (UPPER_CONTOURS, LOWER_CONTOURS)
    )
    if not (len(start) and len(end) and len(faces)):
        return None
    corners, faces = _with_area(corners, faces)
    count = 1 + max(int(nodes.max(initial=0)) for nodes in (faces, *loops.values()))
    piece = find_components(count, faces[:, :2].ravel(), faces[:, 1:].ravel())[1]
    whole = np.isin(piece, np.intersect1d(piece[start], piece[end]))  # loose pieces have no path from start to end
    corners, faces = corners[whole[faces[:, 0]]], faces[whole[faces[:, 0]]]
    if not len(faces):
        return None
    value = np.where(whole, np.nan, 0.0)
    value[start[whole[start]]], value[end[whole[end]]] = 0.0, 1.0
    free = np.flatnonzero(np.isnan(value))
    fixed = np.flatnonzero(~np.isnan(value))
    stiffness = sp.csr_matrix(cotangent_laplacian(corners, faces, count))
    right = -stiffness[free][:, fixed] @ value[fixed]
    value[free] = factor_symmetric(sp.csc_matrix(stiffness[free][:, free])).solve(right)
    flow = float(value @ (stiffness @ value))
    if not flow > 0.0:
        return None
    levels = (np.arange(GIRTH_LEVEL_COUNT * GIRTH_LINE_COUNT) + 0.5) / (GIRTH_LEVEL_COUNT * GIRTH_LINE_COUNT)
    girths = _line_lengths(corners, value[faces], levels).reshape(GIRTH_LEVEL_COUNT, GIRTH_LINE_COUNT).mean(axis=1)
    steps = girths / (flow * GIRTH_LEVEL_COUNT)
    distances = np.cumsum(steps) - 0.5 * steps
    ends = [value[loop].max() for name, loop in loops.items() if name.startswith(ARM_CONTOUR_STEMS)]
    arms = (
        float(np.interp(max(ends), (np.arange(GIRTH_LEVEL_COUNT) + 0.5) / GIRTH_LEVEL_COUNT, distances))
        if ends
        else 0.0
    )
    return GirthProfile(girths, distances, arms)


def _with_area(corners: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the faces with an area: nothing flows through others, and a corner of these alone has no value."""
    corner_numbers = np.arange(corners.shape[0] * 3).reshape(-1, 3)
    flat = corners.shape[2] == 2
    areas = np.abs(signed_areas(corners)) if flat else face_areas(corners.reshape(-1, 3), corner_numbers)
    kept = 2.0 * areas > MIN_DOUBLE_FACE_AREA
    return corners[kept], faces[kept]


def _line_lengths(corners: np.ndarray, value: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Return the sums of the lengths of the level lines over all faces [m], shape [level_count]."""
    order = np.argsort(value, axis=1)
    value = np.take_along_axis(value, order, 1)
    low, middle, high = np.moveaxis(np.take_along_axis(corners, order[:, :, None], 1), 1, 0)
    lengths = []
    for level in levels:
        cut = (value[:, 0] < level) & (level <= value[:, 2])
        (u, v, w), a, b, c = value[cut].T, low[cut], middle[cut], high[cut]
        end = a + ((level - u) / (w - u))[:, None] * (c - a)
        below = level <= v
        gap = np.where(below, v - u, w - v)
        share = np.where(below, level - u, level - v) / np.where(gap > 0.0, gap, 1.0)
        start = np.where(below[:, None], a, b) + share[:, None] * np.where(below[:, None], b - a, c - b)
        lengths.append(float(np.linalg.norm(start - end, axis=1).sum()))
    return np.array(lengths)
