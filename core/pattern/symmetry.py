"""Symmetry of a pattern: pairs of panels that are mirror images, and panels that are their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, lil_matrix

from ..mesh import fit_rigid
from .memo import once
from .orientation import place_points
from .pattern import Edge, Panel, Pattern

FLAT_TOLERANCE = 0.005
"""Largest RMS misfit of mirrored control points, as a fraction of the panel's diagonal: 3 mm on a panel of 60 cm. Below
it lies drafting noise, above it a different cut."""

HANDLE_TOLERANCE = 0.01
"""Largest difference of mirrored curve handles, in chords."""

PLACE_TOLERANCE = 0.25
"""Largest RMS distance in 3D between a placed panel's mirror image and its partner, as a fraction of the panel's
diagonal. Placement is rough (the published T-shirt's sleeves differ by 1 cm), but a front is never
mistaken for a back."""


@dataclass(frozen=True)
class Mirror:
    """Describe that one panel is the mirror image of another, or of itself.

        points[target] = points[source][order] @ rotation.T + shift + rest

    Attributes:
        source, target: Indices of the panels; equal where a panel is its own mirror image.
        order: For each control point of the target, its image's index in the source, shape [n].
        rotation: Orthogonal with determinant -1, shape [2, 2].
        shift: Translation [m], shape [2].
        rest: What the mirror image misses in the pattern as it is [m], at most the tolerance, shape [n, 2].
    """

    source: int
    target: int
    order: np.ndarray
    rotation: np.ndarray
    shift: np.ndarray
    rest: np.ndarray


@dataclass(frozen=True)
class Symmetry:
    """Describe the effective control points of a pattern and the affine map back to all of them.

        points = matrix @ K + offset,    stacked as x0, y0, x1, y1, ...

    Thesis 3.2.2 and algorithm 2. What the drawn pattern misses of exact symmetry (at most the tolerance) is kept in the
    offset, so `expand(reduce(points))` gives the pattern back exactly. A point on its own panel's axis stays on it.

    Attributes:
        effective: Indices into all control points, shape [effective_count].
        matrix: Shape [2 point_count, 2 effective_count].
        offset: Shape [2 point_count].
        mirrors: What was found.
    """

    effective: np.ndarray
    matrix: csr_matrix
    offset: np.ndarray
    mirrors: tuple[Mirror, ...]

    def expand(self, effective: np.ndarray) -> np.ndarray:
        """Return all control points [m], shape [point_count, 2], from effective ones, shape [effective_count, 2]."""
        return (self.matrix @ np.asarray(effective, float).ravel() + self.offset).reshape(-1, 2)

    def reduce(self, points: np.ndarray) -> np.ndarray:
        """Return the effective control points [m], shape [effective_count, 2], out of all, shape [point_count, 2]."""
        return np.asarray(points, float)[self.effective]

    def pull_back(self, gradient: np.ndarray) -> np.ndarray:
        """Return the derivative by the effective points from that by all, shape [point_count, 2]."""
        return (self.matrix.T @ np.asarray(gradient, float).ravel()).reshape(-1, 2)


@once
def find_symmetry(pattern: Pattern) -> Symmetry:
    """Find the left-right symmetry of a pattern (thesis algorithm 2).

    Each pair of panels is aligned by orthogonal Procrustes over all cyclic shifts of the reversed control points; so is
    each panel with itself. Edges in correspondence must be of one kind, with mirrored handles, sewn alike.

    **Deviation** Algorithm 2 accepts any congruent pair. On a T-shirt that ties all four half sleeves together, and a
    skirt's back to its front, which grading then cannot tell apart. So where the file places the panels, a mirror image
    must also stand across the garment's middle plane; the placement also decides between several fitting shifts.

    A pattern that is freed of its symmetry (`Pattern.symmetric`) has none: every control point is effective.
    """
    if not pattern.symmetric:
        return _assemble(pattern, [])
    middle = _middle(pattern)
    panels = pattern.panels
    mirrors: list[Mirror] = []
    taken: set[int] = set()
    for source in range(len(panels)):
        if source in taken:
            continue
        found = [
            (score, target, mirror)
            for target in range(source, len(panels))
            if target not in taken
            for score, mirror in _fits(pattern, source, target, middle)
        ]
        if found:
            _, target, mirror = min(found, key=lambda item: (round(item[0], 9), item[1]))
            mirrors.append(mirror)
            taken |= {source, target}
    return _assemble(pattern, mirrors)


def _middle(pattern: Pattern) -> float | None:
    """Return x of the plane that halves the placed panels, or None where nothing is placed."""
    translations = np.array([panel.translation for panel in pattern.panels])
    if len(pattern.panels) > 1 and np.ptp(translations, axis=0).max() < 1e-6:
        return None
    x = np.concatenate([place_points(panel, panel.points)[:, 0] for panel in pattern.panels])
    return float((x.min() + x.max()) / 2.0)


def _fits(pattern: Pattern, source: int, target: int, middle: float | None) -> list[tuple[float, Mirror]]:
    """Return the acceptable mirror maps from one panel to another, each with its score (smaller is better)."""
    a, b = pattern.panels[source], pattern.panels[target]
    count = len(a.points)
    if len(b.points) != count:
        return []
    diagonal = float(np.linalg.norm(np.ptp(a.points, axis=0)))
    fits = []
    for shift in range(count):
        order = (shift - np.arange(count)) % count
        if not _edges_agree(pattern, a, b, order):
            continue
        motion = fit_rigid(a.points[order], b.points, mirrored=True)
        rotation, move = motion.rotation, motion.translation
        rest = b.points - a.points[order] @ rotation.T - move
        error = float(np.sqrt((rest**2).sum(axis=1).mean())) / diagonal
        if error > FLAT_TOLERANCE:
            continue
        score = error
        if middle is not None:
            image = place_points(a, a.points[order])
            image[:, 0] = 2.0 * middle - image[:, 0]
            score = float(np.sqrt(((image - place_points(b, b.points)) ** 2).sum(axis=1).mean())) / diagonal
            if score > PLACE_TOLERANCE:
                continue
        fits.append((score, Mirror(source, target, order, rotation, move, rest)))
    return fits


def _edges_agree(pattern: Pattern, a: Panel, b: Panel, order: np.ndarray) -> bool:
    """Return whether each edge of b and its image in a are of one kind, with mirrored handles, both sewn or open."""
    sewn = {ref for seam in pattern.seams for ref in (seam.a, seam.b)}
    own = {(ref.panel, ref.edge) for ref in sewn}
    count = len(order)
    for i, edge in enumerate(b.edges):
        # Edge i of b runs from point i to i + 1; its image runs from order[i] back to order[i] - 1.
        j = int(order[i] - 1) % count
        if ((b.name, i) in own) != ((a.name, j) in own) or not _mirror_images(a.edges[j], edge):
            return False
    return True


def _mirror_images(a: Edge, b: Edge) -> bool:
    """Return whether b is a, mirrored and run the other way: (along, across) becomes (1 - along, across)."""
    if a.kind != b.kind or a.handles.shape != b.handles.shape:
        return False
    image = a.handles[::-1] * np.array([-1.0, 1.0]) + np.array([1.0, 0.0])
    return bool(np.all(np.abs(image - b.handles) < HANDLE_TOLERANCE))


def _assemble(pattern: Pattern, mirrors: list[Mirror]) -> Symmetry:
    """Build the effective points and the map back."""
    starts = pattern.point_starts
    dependent: dict[int, tuple[int, Mirror, np.ndarray]] = {}
    on_axis: dict[int, Mirror] = {}
    for mirror in mirrors:
        for j, i in enumerate(mirror.order.tolist()):
            point, image = int(starts[mirror.target] + j), int(starts[mirror.source] + i)
            if point == image:
                on_axis[point] = mirror
            elif mirror.source != mirror.target or image < point:
                dependent[point] = (image, mirror, mirror.rest[j])
    points = pattern.points
    effective = np.array([k for k in range(len(points)) if k not in dependent], dtype=np.int64)
    column = {int(k): n for n, k in enumerate(effective)}
    matrix = lil_matrix((2 * len(points), 2 * len(effective)))
    offset = np.zeros((len(points), 2))
    for k in range(len(points)):
        block, source = np.eye(2), k
        if k in on_axis:
            # Points of the axis satisfy p = Rp + t; (I + R) / 2 projects on it.
            block = (np.eye(2) + on_axis[k].rotation) / 2.0
            offset[k] = points[k] - block @ points[k]
        elif k in dependent:
            source, mirror, _ = dependent[k]
            block = mirror.rotation
            offset[k] = points[k] - block @ points[source]
        n = column[source]
        matrix[2 * k : 2 * k + 2, 2 * n : 2 * n + 2] = block
    return Symmetry(effective, csr_matrix(matrix), offset.ravel(), tuple(mirrors))
