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

ROW_SPACING = 0.015
"""Distance of the places along a seam from which its colours are searched [m]."""

POOLED_ROW_COUNT = 7
"""Number of neighbouring places whose colours are compared together [1]: 10 cm of a seam, more than prints repeat."""

MIN_TONE_DIFFERENCE = 0.15
"""Difference of a channel over the mean one from which two colours are two cloths and not one in light and shade [1]:
three times what a camera's noise of 5 % makes of it."""

MAX_LIGHTING_RATIO = 3.0
"""Ratio of light and shade on one cloth [1]: key light and fill light of a portrait are 2 to 3 times the fill alone."""

MIN_BRIGHTNESS = 0.02
"""Brightness of black cloth [1, of RGB in 0..1]."""

MIN_SEEN_ROWS = 4
"""Number of places that must show a step for the seam to be seen [1]: fewer may be a badge or a button."""

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

    The colours on both sides of places along it are compared with a step (`find_steps`); within an edge of the
    scan's mesh its colours are mixed.

    Args:
        garment: The garment, its nodes on the scan [m].
        target: The scan's surface with its colours.
    """
    if target.colours is None or not len(target.faces):
        return {}
    faces = target.faces[(target.faces < len(target.colours)).all(axis=1)]
    surface = TriangleSurface(target.vertices, faces)
    normals = vertex_normals(garment.nodes, garment.faces)
    edge = np.linalg.norm(surface.vertices[faces[:, 0]] - surface.vertices[faces[:, 1]], axis=1).mean()
    blur, found = int(np.ceil(edge / SEARCH_STEP)), {}
    for line in list_lines(garment.pattern):
        if line.is_open:
            continue
        nodes, row, starts, across = _walk(line, garment, normals)
        offsets = np.arange(-SEARCH_REACH, SEARCH_REACH + 0.5 * SEARCH_STEP, SEARCH_STEP)
        points = starts[:, None] + offsets[None, :, None] * across[:, None]
        closest = surface.closest(points.reshape(-1, 3))
        colours = closest.interpolate(target.colours, faces).reshape(*points.shape)
        near = closest.distance.reshape(points.shape[:2]) < MAX_SURFACE_DISTANCE
        places, is_seen = find_steps(colours, near, blur)
        if is_seen.sum() >= MIN_SEEN_ROWS and is_seen.mean() > 0.5:
            nodes, row = nodes[is_seen[row]], row[is_seen[row]]
            shift = offsets[0] + SEARCH_STEP * places[row]
            found[line] = ColourStep(nodes, across[row], garment.nodes[nodes] + shift[:, None] * across[row])
    return found


def find_steps(colours: np.ndarray, near: np.ndarray, blur: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Find one step in each row of colours, a seam's between two cloths.

    At the step k the least squares of c(x) = a + b x + h H(x - x_k) over the colours of a row and its neighbours, but
    for those that the scan blurs, are least. It is seen where the step h explains most of their variance and the model
    more than a cubic, which shades follow; where the colours differ by more than a shade; and where most rows' steps
    are alike.

    Args:
        colours: Shape [row_count, m, channel_count].
        near: Whether each is on the scan, shape [row_count, m].
        blur: Columns before and behind a step in which the scan mixes both colours.

    Returns:
        The places of the steps in columns, between 0 and m - 1, and which rows show one, both of shape [row_count].
    """
    columns = near.shape[1]
    at = np.linspace(-1.0, 1.0, columns)
    cubic = np.stack([at**k for k in range(4)], axis=1)
    tried = range(blur + 2, columns - blur - 1)
    shares, sides, explained = [], [], []
    for column in tried:
        behind = np.arange(columns) >= column
        clear = near & (np.abs(np.arange(columns) + 0.5 - column) > blur)
        model = np.stack([np.ones(columns), at, np.where(behind, 0.5, -0.5)], axis=1)
        fitted, rest = _fit(model, colours, clear)
        counts = clear.sum(axis=1) * (np.minimum((clear & behind).sum(axis=1), (clear & ~behind).sum(axis=1)) > 2)
        spread, smooth = (_pool(_fit(terms, colours, clear)[1]) for terms in (np.ones((columns, 1)), cubic))
        rest, height = _pool(rest), _pool(fitted[:, 2])
        middle = _pool(fitted[:, 0] + fitted[:, 1] * at[[column - 1, column]].mean())
        by_step = 0.25 * _pool(counts.astype(float)) * (height**2).sum(axis=1)
        shares.append(np.where(spread > 0.0, rest / np.maximum(spread, 1e-12), np.inf))
        explained.append((by_step > MIN_EXPLAINED_SHARE * spread) & (rest < smooth))
        sides.append((middle - 0.5 * height, middle + 0.5 * height))
    best, row = np.argmin(shares, axis=0), np.arange(len(near))
    left, right = np.moveaxis(np.array(sides)[best, :, row], 1, 0)
    height, is_seen = right - left, np.array(explained)[best, row] & _differ_by_more_than_shade(left, right)
    if is_seen.any():
        common = np.median(height[is_seen], axis=0)
        is_seen &= height @ common > 0.5 * float(common @ common)
    return np.array(tried)[best] - 0.5, is_seen


def _differ_by_more_than_shade(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Check which pairs of colours, shape [n, channel_count] each, are not one colour in light and shade."""
    left, right = np.maximum(left, MIN_BRIGHTNESS), np.maximum(right, MIN_BRIGHTNESS)
    bright = np.stack([left.mean(axis=1), right.mean(axis=1)])
    tones = np.abs(left / bright[0][:, None] - right / bright[1][:, None]).max(axis=1)
    return np.asarray((tones > MIN_TONE_DIFFERENCE) | (bright.max(axis=0) > MAX_LIGHTING_RATIO * bright.min(axis=0)))


def _pool(values: np.ndarray) -> np.ndarray:
    """Return the mean of each row's values and those of `POOLED_ROW_COUNT` rows about it, at the ends fewer."""
    reach = POOLED_ROW_COUNT // 2
    sums = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    ends = np.arange(len(values))
    first, last = np.maximum(ends - reach, 0), np.minimum(ends + reach + 1, len(values))
    counts = (last - first).reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray((sums[last] - sums[first]) / counts)


def _fit(terms: np.ndarray, colours: np.ndarray, clear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least squares of terms, shape [m, k], to the clear colours of each row: coefficients, shape [n, k,
    channel_count], and squared residuals, shape [n]."""
    weighted = clear[:, :, None] * terms
    gram = np.swapaxes(weighted, 1, 2) @ terms + 1e-9 * np.eye(terms.shape[1])
    found = np.linalg.solve(gram, np.swapaxes(weighted, 1, 2) @ colours)
    return found, (clear[:, :, None] * (colours - terms @ found) ** 2).sum(axis=(1, 2))


def _walk(
    line: PatternLine, garment: Garment, normals: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return a seam's inner nodes, shape [n], and the row next to each; of each row of its search, `ROW_SPACING` apart,
    the place on the seam and the unit direction across it, shape [m, 3] each."""
    nodes, rows, starts, across = [], [], [], []
    count = 0
    for ref in line.edges:
        path = garment.uv_node[garment.edge_uv[ref]]
        points = garment.nodes[path]
        pieces = np.linalg.norm(np.diff(points, axis=0), axis=1)
        arc = np.concatenate([[0.0], np.cumsum(pieces)])
        number = max(int(arc[-1] / ROW_SPACING), 1)
        at = (np.arange(number) + 0.5) * arc[-1] / number
        ahead, behind = (
            _interpolate(np.clip(at + way, 0.0, arc[-1]), arc, points) for way in (ROW_SPACING, -ROW_SPACING)
        )
        starts.append(_interpolate(at, arc, points))
        across.append(unit(np.cross(_interpolate(at, arc, normals[path]), ahead - behind)))
        nodes.append(path[1:-1])
        rows.append(count + np.abs(arc[1:-1, None] - at).argmin(axis=1))
        count += number
    return np.concatenate(nodes), np.concatenate(rows), np.concatenate(starts), np.concatenate(across)


def _interpolate(at: np.ndarray, arc: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(at, arc, column) for column in values.T], axis=1)
