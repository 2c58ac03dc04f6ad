"""Panels that are mirror images of each other, or of themselves."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from ..geometry.rigid import fit_rigid
from .orientation import place_points
from .pattern import EdgeRef, Pattern

FLAT_TOLERANCE = 0.005
"""Largest RMS misfit of mirrored control points, as a fraction of the panel's diagonal: 3 mm on a panel of 60 cm.
Drafting noise is below it, a different cut above it."""

HANDLE_TOLERANCE = 0.01
"""Largest difference of mirrored curve handles [chords]."""

PLACE_TOLERANCE = 0.25
"""Largest RMS distance in 3D between a placed panel's mirror image and its partner, as a fraction of the panel's
diagonal. Placement is rough (the published T-shirt's sleeves differ by 1 cm); front and back are further apart."""

MAX_MIRROR_POINT_PAIRS = 2**17
"""Number of pairs of control points that are compared at once: a few MB."""


@dataclass(frozen=True)
class Mirror:
    """Describe that one panel is the mirror image of another, or of itself.

        points[target] = points[source][order] @ rotation.T + shift + rest

    Attributes:
        source, target: Indices of the panels; equal where a panel is its own mirror image.
        order: For each control point of the target, its image's index in the source, shape [n].
        rotation: Orthogonal with determinant -1, shape [2, 2].
        shift: Translation [m], shape [2].
        rest: Misfit of the mirror image in the given pattern [m], at most the tolerance, shape [n, 2].
    """

    source: int
    target: int
    order: np.ndarray
    rotation: np.ndarray
    shift: np.ndarray
    rest: np.ndarray


@dataclass(frozen=True)
class _Group:
    """Describe k panels with n edges each for the comparison.

    Attributes:
        panels: Their indices in the pattern, shape [k].
        kinds: One number for an edge's kind, its number of handles and whether it is sewn, shape [k, n].
        handles: Shape [k, n, handle_count, 2], zeros where an edge has fewer.
        images: The handles of each edge, mirrored and reversed: (along, across) becomes (1 - along, across).
        points: Control points [m], shape [k, n, 2].
        placed: The same, placed in 3D [m], shape [k, n, 3].
    """

    panels: np.ndarray
    kinds: np.ndarray
    handles: np.ndarray
    images: np.ndarray
    points: np.ndarray
    placed: np.ndarray


def find_mirrors(pattern: Pattern) -> list[Mirror]:
    """Find for each panel the one that fits its mirror image best, perhaps itself; each panel is in at most one pair.
    All cyclic shifts of the reversed control points are tried, aligned by orthogonal Procrustes. Corresponding edges
    must have one kind and mirrored handles, and be both sewn or both open."""
    middle = _middle(pattern)
    mirrors = []
    for group in _stack(pattern):
        is_free = np.ones(len(group.panels), bool)
        for source in range(len(group.panels)):
            if not is_free[source]:
                continue
            targets = source + np.flatnonzero(is_free[source:])
            best = min(_list_fits(group, source, targets, middle), default=None)
            if best is not None:
                _, target, shift = best
                is_free[[source, target]] = False
                mirrors.append(_make_mirror(pattern, int(group.panels[source]), int(group.panels[target]), shift))
    return sorted(mirrors, key=lambda mirror: mirror.source)


def _middle(pattern: Pattern) -> float | None:
    """Return x of the middle plane of the placed panels, or None where nothing is placed."""
    translations = np.array([panel.translation for panel in pattern.panels])
    if len(pattern.panels) > 1 and np.ptp(translations, axis=0).max() < 1e-6:
        return None
    x = np.concatenate([place_points(panel, panel.points)[:, 0] for panel in pattern.panels])
    return float((x.min() + x.max()) / 2.0)


def _stack(pattern: Pattern) -> list[_Group]:
    """Return the panels, grouped by their numbers of edges."""
    sewn = {ref for seam in pattern.seams for ref in (seam.a, seam.b)}
    most = max(len(edge.handles) for panel in pattern.panels for edge in panel.edges)
    numbers: dict[tuple[str, int, bool], int] = {}
    groups = defaultdict(list)
    for index, panel in enumerate(pattern.panels):
        groups[len(panel.points)].append(index)
    found = []
    for count, members in groups.items():
        kinds = np.zeros((len(members), count), int)
        handles, images = np.zeros((2, len(members), count, most, 2))
        for at, index in enumerate(members):
            panel = pattern.panels[index]
            for i, edge in enumerate(panel.edges):
                kind = (edge.kind, len(edge.handles), EdgeRef(panel.name, i) in sewn)
                kinds[at, i] = numbers.setdefault(kind, len(numbers))
                handles[at, i, : len(edge.handles)] = edge.handles
                images[at, i, : len(edge.handles)] = edge.handles[::-1] * np.array([-1.0, 1.0]) + np.array([1.0, 0.0])
        panels = [pattern.panels[index] for index in members]
        points = np.stack([panel.points for panel in panels])
        placed = np.stack([place_points(panel, panel.points) for panel in panels])
        found.append(_Group(np.array(members), kinds, handles, images, points, placed))
    return found


def _list_fits(group: _Group, source: int, targets: np.ndarray, middle: float | None) -> list[tuple[float, int, int]]:
    """Return the acceptable mirror maps of one panel to others: score (smaller is better), target and cyclic shift."""
    count = group.points.shape[1]
    diagonal = float(np.linalg.norm(np.ptp(group.points[source], axis=0)))
    fits: list[tuple[float, int, int]] = []
    step = max(1, MAX_MIRROR_POINT_PAIRS // (len(targets) * count))
    for first in range(0, count, step):
        shifts = np.arange(first, min(first + step, count))
        order = _reverse(shifts, count)
        target, row = np.nonzero((group.kinds[source][order - 1] == group.kinds[targets][:, None]).all(axis=2))
        target = targets[target]
        # Edge i joins points i and i + 1; its image joins order[i] and order[i] - 1.
        apart = np.abs(group.images[source][order[row] - 1] - group.handles[target])
        is_like = (apart < HANDLE_TOLERANCE).all(axis=(1, 2, 3))
        target, row = target[is_like], row[is_like]
        score = _misfits(group.points[source][order[row]], group.points[target]) / diagonal
        keep = score <= FLAT_TOLERANCE
        target, row, score = target[keep], row[keep], score[keep]
        if middle is not None:
            image = group.placed[source][order[row]]
            image[..., 0] = 2.0 * middle - image[..., 0]
            score = np.sqrt(((image - group.placed[target]) ** 2).sum(axis=2).mean(axis=1)) / diagonal
            keep = score <= PLACE_TOLERANCE
            target, row, score = target[keep], row[keep], score[keep]
        fits += zip(score.round(9).tolist(), target.tolist(), shifts[row].tolist(), strict=True)
    return fits


def _reverse(shifts: np.ndarray, count: int) -> np.ndarray:
    """Return the control points in reversed order from each of some starts, shape [shift_count, count]."""
    return (shifts[:, None] - np.arange(count)) % count


def _misfits(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the RMS distance [m] of points b from the best mirror image of a, shape [n, point_count, 2], each. A
    mirror image by R = [[c, s], [s, -c]] is best where (c, s) is parallel to (H_xx - H_yy, H_xy + H_yx), H = sum b
    a^T."""
    a, b = a - a.mean(axis=1, keepdims=True), b - b.mean(axis=1, keepdims=True)
    moments = np.einsum("nik,nil->nkl", b, a)
    along, across = moments[:, 0, 0] - moments[:, 1, 1], moments[:, 0, 1] + moments[:, 1, 0]
    length = np.hypot(along, across)
    c = np.where(length > 0.0, along, 1.0) / np.where(length > 0.0, length, 1.0)
    s = across / np.where(length > 0.0, length, 1.0)
    x = b[..., 0] - c[:, None] * a[..., 0] - s[:, None] * a[..., 1]
    y = b[..., 1] - s[:, None] * a[..., 0] + c[:, None] * a[..., 1]
    return np.asarray(np.sqrt((x**2 + y**2).mean(axis=1)))


def _make_mirror(pattern: Pattern, source: int, target: int, shift: int) -> Mirror:
    """Return the mirror map of one panel to another at a cyclic shift."""
    a, b = pattern.panels[source].points, pattern.panels[target].points
    order = _reverse(np.array([shift]), len(b))[0]
    motion = fit_rigid(a[order], b, mirrored=True)
    rest = b - a[order] @ motion.rotation.T - motion.translation
    return Mirror(source, target, order, motion.rotation, motion.translation, rest)
