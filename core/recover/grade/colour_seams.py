"""Find seams between cloths of two colours: where along a seam the scan's colours make one step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...garment.garment import Garment
from ...garment.pieces.pattern_lines import PatternLine, list_lines
from ...geometry.geometry import unit, vertex_normals
from ...geometry.surface import TriangleSurface
from ...scan.contours.target import Target

SEARCH_REACH = 0.04
"""Distance from a drafted seam within which its colours are searched [m]: twice by which an armhole was misplaced."""

SEARCH_STEP = 0.002
"""Step of the search [m]: the distance of a scan's vertices."""

MIN_EXPLAINED_SHARE = 0.5
"""Share of the colours' variance across a seam from which one step explains them [1]: most of it. Of prints and noise
it explains less; a stripe has two steps."""

MIN_SEEN_NODES = 4
"""Number of a seam's nodes that must show a step for the seam to be seen [1]: fewer may be a badge or a button."""

MAX_SURFACE_DISTANCE = 0.015
"""Distance from the scan beyond which a searched point is beside it [m]: half a fold."""


@dataclass(frozen=True)
class ColourStep:
    """Describe where colours change along a seam.

    Attributes:
        nodes: Nodes of the seam that show it, shape [n].
        across: Unit directions across the seam, in the cloth, shape [n, 3].
        places: Points of the change [m], shape [n, 3].
    """

    nodes: np.ndarray
    across: np.ndarray
    places: np.ndarray

    def is_at(self, nodes: np.ndarray, distance: float) -> bool:
        """Check whether most of its nodes lie within a distance [m] of the change, given all nodes [m]."""
        off = ((nodes[self.nodes] - self.places) * self.across).sum(axis=1)
        return bool((np.abs(off) < distance).mean() > 0.5)


def find_colour_steps(garment: Garment, target: Target) -> dict[PatternLine, ColourStep]:
    """Find the seams at which a scan's colours make a step, and where; none on a scan without colours.

    The colours at points on both sides of each node are split in two at the place that explains most of their variance;
    the two colours are those of the whole seam. They must explain more than a cubic, which shades follow.

    Args:
        garment: The garment, its nodes on the scan [m].
        target: The scan's surface with its colours.
    """
    if target.colours is None or not len(target.faces):
        return {}
    surface = TriangleSurface(target.vertices, target.faces)
    normals = vertex_normals(garment.nodes, garment.faces)
    found = {}
    for line in list_lines(garment.pattern):
        if line.is_open:
            continue
        nodes, along = _walk(line, garment)
        across = unit(np.cross(normals[nodes], along))
        offsets = np.arange(-SEARCH_REACH, SEARCH_REACH + 0.5 * SEARCH_STEP, SEARCH_STEP)
        points = garment.nodes[nodes][:, None] + offsets[None, :, None] * across[:, None]
        closest = surface.closest(points.reshape(-1, 3))
        colours = closest.interpolate(target.colours, target.faces).reshape(*points.shape)
        near = closest.distance.reshape(points.shape[:2]) < MAX_SURFACE_DISTANCE
        places, is_seen = find_steps(colours, near)
        if is_seen.sum() >= MIN_SEEN_NODES and is_seen.mean() > 0.5:
            shift = offsets[0] + SEARCH_STEP * places[is_seen]
            feet = garment.nodes[nodes[is_seen]] + shift[:, None] * across[is_seen]
            found[line] = ColourStep(nodes[is_seen], across[is_seen], feet)
    return found


def find_steps(colours: np.ndarray, near: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find one step in each row of colours, between two colours of all rows.

    With the mean colours l and r of what lies before and behind the steps k of the rows, k minimises
    sum_{j < k} |c_j - l|^2 + sum_{j >= k} |c_j - r|^2; both are found in turn, from the best step that all rows share.

    Args:
        colours: Shape [row_count, m, channel_count].
        near: Whether each is on the scan, shape [row_count, m].

    Returns:
        The places of the steps in columns, between 0 and m - 1, and which rows' colours they explain, both of shape
            [row_count].
    """
    weight = near.astype(float)
    columns = colours.shape[1]
    best, steps = np.inf, np.full(len(colours), columns // 2)
    for shared in range(2, columns - 1):
        cost = _cost(colours, weight, np.full(len(colours), shared))
        if cost < best:
            best, steps = cost, np.full(len(colours), shared)
    for _ in range(5):
        left, right = _side_means(colours, weight, steps)
        behind = weight * ((colours - right) ** 2).sum(axis=2) - weight * ((colours - left) ** 2).sum(axis=2)
        # cost of a step at k, up to a constant: what lies from k on is compared with the right colour
        costs = np.cumsum(np.pad(behind[:, ::-1], ((0, 0), (1, 0))), axis=1)[:, ::-1]
        chosen = costs.argmin(axis=1)
        if np.array_equal(chosen, steps):
            break
        steps = chosen
    left, right = _side_means(colours, weight, steps)
    inner = (steps > 1) & (steps < columns - 1)
    model = np.where((np.arange(columns) < steps[:, None])[:, :, None], left, right)
    rest = (weight * ((colours - model) ** 2).sum(axis=2)).sum(axis=1)
    own = np.einsum("ij,ijk->i", weight, (colours - _row_means(colours, weight)[:, None]) ** 2)
    explained = (rest < (1.0 - MIN_EXPLAINED_SHARE) * own) & (rest < _measure_smooth_rest(colours, weight))
    return steps - 0.5, inner & explained


def _measure_smooth_rest(colours: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the squared differences of each row's colours from a cubic along it, which shades follow, shape [n]."""
    at = np.linspace(-1.0, 1.0, colours.shape[1])
    terms = np.stack([at**k for k in range(4)], axis=1)
    root = np.sqrt(weight)[:, :, None]
    scaled, values = root * terms, root * colours
    fitted = scaled @ (np.linalg.pinv(scaled) @ values)
    return np.asarray(((values - fitted) ** 2).sum(axis=(1, 2)))


def _row_means(colours: np.ndarray, weight: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("ij,ijk->ik", weight, colours) / np.maximum(weight.sum(axis=1), 1.0)[:, None])


def _side_means(colours: np.ndarray, weight: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean colours before and behind the steps, shape [channel_count] each."""
    before = weight * (np.arange(colours.shape[1]) < steps[:, None])
    sides = [np.einsum("ij,ijk->k", own, colours) / max(own.sum(), 1.0) for own in (before, weight - before)]
    return sides[0], sides[1]


def _cost(colours: np.ndarray, weight: np.ndarray, steps: np.ndarray) -> float:
    left, right = _side_means(colours, weight, steps)
    model = np.where((np.arange(colours.shape[1]) < steps[:, None])[:, :, None], left, right)
    return float((weight * ((colours - model) ** 2).sum(axis=2)).sum())


def _walk(line: PatternLine, garment: Garment) -> tuple[np.ndarray, np.ndarray]:
    """Return the inner nodes of a seam, shape [n], and the directions along it there, shape [n, 3]."""
    nodes, along = [], []
    for ref in line.edges:
        path = garment.uv_node[garment.edge_uv[ref]]
        nodes.append(path[1:-1])
        along.append(garment.nodes[path[2:]] - garment.nodes[path[:-2]])
    return np.concatenate(nodes), unit(np.concatenate(along))
