"""Cut planned darts into a fitted garment, in its pattern and base pattern, and move its nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...garment.control import map_controls, mean_value_coordinates
from ...garment.curves import edge_length, edge_points
from ...garment.editing.darts import DART_LABEL, Dart, find_darts, insert_dart
from ...garment.editing.edge_division import MIN_SPLIT_SHARE
from ...garment.garment import Garment
from ...garment.pattern import EdgeRef, Pattern
from ...garment.resampling import locate
from ...garment.seams import equalise_seams
from ...garment.symmetry import find_symmetry
from ...geometry.rigid import fit_rigid
from .dart_search import PlannedDart, mirror_of, reflect_wedge, relax_panel
from .wedge import FlatPanel, Wedge

DART_MOUTH_SAMPLE_COUNT = 200
"""Number of segments of an edge between which the place nearest to the mouth of a dart is found."""

MAX_DART_MEETING_DISTANCE = 0.03
"""Distance along an edge from a point where a dart begins on the seam's other side, below which a mouth takes that
point [m], so that darts above and below a seam meet."""


@dataclass(frozen=True)
class OpenPanel:
    """Describe how a panel opens at its darts.

    Attributes:
        panel: The relaxed panel without the darts.
        wedges: The planned darts.
        angle: Of each [rad].
        motion: Of each flat vertex [m], shape [vertex_count, 2].
        uv, faces, corner: The opened panel: flat vertices [m], shape [n, 2], faces, and the vertex of `panel` that each
            is, shape [n]; faces that a dart cuts occur twice, once for each of its sides.
    """

    panel: FlatPanel
    wedges: tuple[Wedge, ...]
    angle: float
    motion: np.ndarray
    uv: np.ndarray
    faces: np.ndarray
    corner: np.ndarray

    @classmethod
    def of(cls, panel: FlatPanel, wedges: tuple[Wedge, ...], angle: float) -> OpenPanel:
        """Open a panel at wedges of one angle with the least strain."""
        load = angle * panel.loads(wedges).sum(axis=1)
        target = panel.left + panel.operator @ panel.motion.ravel() + load
        motion = panel.factor.solve(panel.operator.T @ target).reshape(-1, 2)
        moved = panel.uv + motion
        whole = np.ones(len(panel.faces), dtype=bool)
        uv, faces, corner = [moved], [], [np.arange(len(moved))]
        count = len(moved)
        for wedge in wedges:
            cut, jump = panel.jump(wedge)
            whole[cut] = False
            at = panel.uv[panel.faces[cut]]
            follows = (np.linalg.norm(jump, axis=2) == 0.0) & ((at - wedge.apex) @ (wedge.apex - wedge.mouth) < 0.0)
            corners = moved[panel.faces[cut]]
            right = corners - angle * jump
            left = corners + np.where(follows[..., None], angle * _rotation_about_apex(at, wedge), 0.0)
            for side in (right, left):
                uv.append(side.reshape(-1, 2))
                faces.append(count + np.arange(3 * len(cut)).reshape(-1, 3))
                corner.append(panel.faces[cut].reshape(-1))
                count += 3 * len(cut)
        faces.insert(0, panel.faces[whole])
        return cls(panel, wedges, angle, motion, np.concatenate(uv), np.concatenate(faces), np.concatenate(corner))

    def mouth(self, wedge: Wedge) -> tuple[np.ndarray, np.ndarray]:
        """Return the left and right end of an opened mouth [m], seen from it towards the apex, shape [2] each."""
        axis = (wedge.apex - wedge.mouth) / wedge.length
        offset = self.panel.uv - wedge.mouth
        ends = np.argsort(np.linalg.norm(offset, axis=1))[:2]
        side = axis[0] * offset[ends, 1] - axis[1] * offset[ends, 0]
        jump = self.angle * _rotation_about_apex(wedge.mouth[None], wedge)[0]
        # two vertices of the outline are nearest to the mouth, one of them, or both, to its left
        base = np.mean([self.motion[i] - (jump if left else 0.0) for i, left in zip(ends, side > 0.0, strict=True)], 0)
        return wedge.mouth + base + jump, wedge.mouth + base

    def apex(self, wedge: Wedge) -> np.ndarray:
        """Return the place of an apex after opening [m], shape [2]."""
        return np.asarray(wedge.apex + self.motion[np.argmin(np.linalg.norm(self.panel.uv - wedge.apex, axis=1))])


def _rotation_about_apex(points: np.ndarray, wedge: Wedge) -> np.ndarray:
    """Return the displacements of points by a clockwise turn of one radian about a wedge's apex [m], shape [..., 2]."""
    offset = points - wedge.apex
    return np.stack([offset[..., 1], -offset[..., 0]], axis=-1)


@dataclass(frozen=True)
class CutGarment:
    """Describe a garment whose panels got darts.

    Attributes:
        before: The garment without them.
        opened: Opened panels by index.
        drawn: The pattern as they opened it; its seams are not equal yet.
        pattern: With equal seams.
        base: The base pattern with the same darts.
        darts: Of `pattern`; a planned dart and its mirror image follow each other.
        owner: For each dart the number of its plan.
    """

    before: Garment
    opened: dict[int, OpenPanel]
    drawn: Pattern
    pattern: Pattern
    base: Pattern
    darts: tuple[Dart, ...]
    owner: tuple[int, ...]

    def place(self, source: Garment, nodes: np.ndarray, target: Garment) -> np.ndarray:
        """Return the nodes of a mesh with the darts [m], shape [node_count, 3].

        Args:
            source: A mesh of the pattern without the darts.
            nodes: Its nodes [m], shape [source node_count, 3].
            target: A mesh of the pattern with them, for any control points.
        """
        mapped = map_controls(source).apply(self.before.pattern.points)
        queries = self._unopened(target, map_controls(target).apply(self.drawn.points), target.panel_of_uv)
        found = np.zeros((len(target.uv), 3))
        for index in range(len(self.drawn.panels)):
            in_panel = target.panel_of_uv == index
            corner, weight = locate(mapped, source.uv_faces[source.panel_of_face == index], queries[in_panel])
            found[in_panel] = np.einsum("nk,nkd->nd", weight, nodes[source.uv_node[corner]])
        count = len(target.nodes)
        sum_of = [np.bincount(target.uv_node, found[:, k], count) for k in range(3)]
        return np.stack(sum_of, axis=1) / np.bincount(target.uv_node, minlength=count)[:, None]

    def carry_strain(self, strain: np.ndarray, target: Garment) -> np.ndarray:
        """Return the strain of the faces of a mesh with the darts, from the nearest faces, shape [face_count, 2, 2].

        Args:
            strain: Of the faces of the garment without the darts, shape [face_count, 2, 2].
            target: A mesh of the pattern with them, for any control points.
        """
        flat = map_controls(target).apply(self.drawn.points)
        queries = self._unopened(target, flat[target.uv_faces].mean(axis=1), target.panel_of_face)
        middles, found = self.before.rest.mean(axis=1), np.zeros((len(target.faces), 2, 2))
        for index in range(len(self.drawn.panels)):
            old, new = np.flatnonzero(self.before.panel_of_face == index), target.panel_of_face == index
            found[new] = strain[old[cKDTree(middles[old]).query(queries[new])[1]]]
        return found

    def _unopened(self, target: Garment, points: np.ndarray, panel_of: np.ndarray) -> np.ndarray:
        """Return points of the opened panels as before opening [m], shape [n, 2]."""
        found = points.copy()
        for index, opened in self.opened.items():
            in_panel = panel_of == index
            corner, weight = locate(opened.uv, opened.faces, points[in_panel], is_within=False)
            found[in_panel] = np.einsum("nk,nkd->nd", weight, opened.panel.uv[opened.corner[corner]])
        return found


def cut_darts(garment: Garment, strain: np.ndarray, base: Pattern, planned: tuple[PlannedDart, ...]) -> CutGarment:
    """Cut darts into a fitted garment and its base pattern, and open them.

    Args:
        garment: The flat panels, fitted to the cloth on the target.
        strain: Wanted strain of each face, shape [face_count, 2, 2].
        base: The base pattern.
        planned: The darts, at most one a panel and none in a panel's mirror image.
    """
    pattern, template = garment.pattern, base
    opened: dict[int, OpenPanel] = {}
    ends: dict[tuple[str, tuple[float, ...]], tuple[OpenPanel, Wedge]] = {}
    owners: dict[tuple[str, tuple[float, ...]], int] = {}
    for number, plan in enumerate(planned):
        for index, wedges in _wedges_of(garment, plan).items():
            opened[index] = OpenPanel.of(relax_panel(garment, strain, index), wedges, plan.angle)
            name = pattern.panels[index].name
            for wedge in wedges:
                edge, at = _find_mouth(pattern, name, wedge.mouth)
                there = mean_value_coordinates(garment.pattern.panel(name).points, wedge.apex[None])[0]
                template, _ = insert_dart(template, edge, at, there @ base.panel(name).points)
                pattern, _ = insert_dart(pattern, edge, at, wedge.apex)
                ends[name, tuple(wedge.apex)] = opened[index], wedge
                owners[name, tuple(wedge.apex)] = number
    keys = [(dart.panel, tuple(dart.ends(pattern)[1])) for dart in find_darts(pattern)]
    darts = tuple(dart for dart, key in zip(find_darts(pattern), keys, strict=True) if key in ends)
    symmetry = find_symmetry(template)
    drawn = _open_darts(pattern, opened, {dart: ends[dart.panel, tuple(dart.ends(pattern)[1])] for dart in darts})
    drawn = drawn.with_points(symmetry.expand(symmetry.reduce(drawn.points)))
    even = equalise_seams(drawn, base=template, symmetry=symmetry)
    owner = tuple(owners[key] for key in keys if key in ends)
    return CutGarment(garment, opened, drawn, even, _transfer_opening(template, pattern, drawn), darts, owner)


def relax_panels(garment: Garment, strain: np.ndarray, base: Pattern, panels: set[str]) -> tuple[Pattern, Pattern]:
    """Return a pattern and its base with some panels relaxed to their wanted strain: darts open or close freely.

    Args:
        garment: The flat panels, fitted to the cloth on the target.
        strain: Wanted strain of each face, shape [face_count, 2, 2].
        base: The base pattern, with the same darts.
        panels: Names of the panels.
    """
    points = {}
    for index, panel in enumerate(garment.pattern.panels):
        if panel.name in panels:
            first = int(np.flatnonzero(garment.panel_of_uv == index)[0])
            corners = [garment.edge_uv[EdgeRef(panel.name, i)][0] - first for i in range(len(panel.points))]
            points[panel.name] = panel.points + relax_panel(garment, strain, index).motion[corners]
    symmetry = find_symmetry(base)
    drawn = garment.pattern.with_points(points)
    drawn = drawn.with_points(symmetry.expand(symmetry.reduce(drawn.points)))
    return equalise_seams(drawn, base=base, symmetry=symmetry), _transfer_opening(base, garment.pattern, drawn)


def _wedges_of(garment: Garment, plan: PlannedDart) -> dict[int, tuple[Wedge, ...]]:
    """Return the wedges of a planned dart and of its mirror image, by the panel's index."""
    mirror = mirror_of(garment, plan.panel)
    if mirror is None:
        return {plan.panel: (plan.wedge,)}
    image = reflect_wedge(mirror, plan.wedge)
    if mirror.target == plan.panel:
        return {plan.panel: (plan.wedge, image)}
    return {plan.panel: (plan.wedge,), mirror.target: (image,)}


def _find_mouth(pattern: Pattern, panel: str, place: np.ndarray) -> tuple[EdgeRef, float]:
    """Return the edge at a place of an outline, and the fraction of its length; 0 where a dart can meet another."""
    drawn = pattern.panel(panel)
    _, number, at = min(
        (float(line[k]), i, k / (len(line) - 1))
        for i in range(len(drawn.edges))
        if drawn.edges[i].label != DART_LABEL
        for line in [np.linalg.norm(edge_points(drawn, i, DART_MOUTH_SAMPLE_COUNT) - place, axis=1)]
        for k in [int(np.argmin(line))]
    )
    length = edge_length(drawn, number)
    if at * length < MAX_DART_MEETING_DISTANCE and _meets_dart(pattern, EdgeRef(panel, number)):
        return EdgeRef(panel, number), 0.0
    after = EdgeRef(panel, (number + 1) % len(drawn.edges))
    if (1.0 - at) * length < MAX_DART_MEETING_DISTANCE and _meets_dart(pattern, after):
        return after, 0.0
    return EdgeRef(panel, number), min(max(at, MIN_SPLIT_SHARE), 1.0 - MIN_SPLIT_SHARE)


def _meets_dart(pattern: Pattern, edge: EdgeRef) -> bool:
    """Return whether a dart begins on the other side of the seam where an edge begins, and none on this side."""
    sewn = {seam.a: seam.b for seam in pattern.seams} | {seam.b: seam.a for seam in pattern.seams}
    before = EdgeRef(edge.panel, (edge.edge - 1) % len(pattern.panel(edge.panel).edges))
    one, other = sewn.get(edge), sewn.get(before)
    if one is None or other is None or one.panel != other.panel or one.panel == edge.panel:
        return False
    count = len(pattern.panel(one.panel).points)
    return Dart(one.panel, (one.edge + 1) % count) in find_darts(pattern)


def _open_darts(pattern: Pattern, opened: dict[int, OpenPanel], ends: dict[Dart, tuple[OpenPanel, Wedge]]) -> Pattern:
    """Return a pattern whose control points have moved with its opening panels."""
    points = {}
    for index, panel in opened.items():
        drawn = pattern.panels[index]
        corner, weight = locate(panel.panel.uv, panel.panel.faces, drawn.points)
        points[drawn.name] = drawn.points + np.einsum("nk,nkd->nd", weight, panel.motion[corner])
    for dart, (panel, wedge) in ends.items():
        panel_points = points[dart.panel]
        at, count = pattern.panel(dart.panel).points, len(panel_points)
        left, right = panel.mouth(wedge)
        first, apex, last = ((dart.first + k) % count for k in range(3))
        panel_points[first], panel_points[last] = at[first] + left - wedge.mouth, at[last] + right - wedge.mouth
        panel_points[apex] = panel.apex(wedge)
    return pattern.with_points(points)


def _transfer_opening(fitted: Pattern, closed: Pattern, opened: Pattern) -> Pattern:
    """Return a base pattern opened as a fitted pattern, whose panels may be rotated against its own."""
    points = {}
    for base, before, after in zip(fitted.panels, closed.panels, opened.panels, strict=True):
        turn = fit_rigid(before.points, base.points).rotation
        points[base.name] = base.points + (after.points - before.points) @ turn.T
    moved = fitted.with_points(points)
    symmetry = find_symmetry(fitted)
    moved = moved.with_points(symmetry.expand(symmetry.reduce(moved.points)))
    return equalise_seams(moved, base=fitted, symmetry=symmetry)
