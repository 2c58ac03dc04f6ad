"""Girths of a body in its T-pose, as a tape measure takes them: convex hulls of exact cross-sections."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from ..geometry.connectivity import HalfEdges, find_components
from .body import Body
from .skinning import rest_body

MIN_LIMB_GIRTH = 0.12
"""Length of a loop below which no part of a body fits through it [m]: a child's wrist has 13 cm."""

GIRTHS = ("chest", "waist", "hip", "thigh", "upper_arm")
"""Names of the girths: of the trunk below the arms, where it is narrowest, where it is widest between crotch and
pelvis; of a thigh below the crotch; of an upper arm. The last two are means of both sides."""

GIRTH_LEVEL_SPACING = 0.01
"""Spacing of the heights at which the narrowest and the widest cross-section are sought [m]: the vertices' spacing."""

MAX_CROTCH_OFFSET = 0.01
"""Distance from the median plane within which the crotch is sought [m]: the spacing of the body's vertices."""

ARMPIT_PROBE_OFFSET = 0.04
"""Distance outward of the shoulder joint at which the arm's underside gives the height of the armpit [m]: beyond the
rounding from trunk to arm, before the arm tapers."""

BELOW_ARMPIT = 0.04
"""Distance of the chest girth below the armpit [m], where a tape passes under the arms."""

BELOW_CROTCH = 0.03
"""Distance of the thigh girth below the crotch [m], where the legs are separate."""

BICEPS_POSITION_SHARE = 0.35
"""Share of the way from shoulder to elbow at which the upper arm is measured: the middle of the biceps."""


def crotch_height(body: Body) -> float:
    """Return the height of the crotch in the T-pose [m]: the lowest skin in the median plane above the knees."""
    pelvis = body.joint("pelvis")
    middle = np.abs(body.vertices[:, 0] - pelvis[0]) < MAX_CROTCH_OFFSET
    heights = body.vertices[middle & (body.vertices[:, 1] > 0.5 * pelvis[1]), 1]
    return float(heights.min()) if len(heights) else 0.5 * float(pelvis[1])


def armpit_height(body: Body) -> float:
    """Return the height of the armpits of a body in its T-pose [m]: the lowest skin at the arms' roots. If a coarse
    mesh has no vertex there, return the height of the shoulder joint."""
    centre, shoulder = body.joint("pelvis")[0], body.joint("left_shoulder")
    off, heights = np.abs(body.vertices[:, 0] - centre), body.vertices[:, 1]
    root = (np.abs(off - abs(shoulder[0] - centre) - ARMPIT_PROBE_OFFSET) < GIRTH_LEVEL_SPACING) & (
        heights > body.joint("spine3")[1]
    )
    return float(heights[root].min(initial=shoulder[1]))


@dataclass(frozen=True)
class Girth:
    """Describe one girth.

    Attributes:
        value: The girth [m].
        level: Where it was measured: a height [m]; of the upper arm, the distance from the median plane.
        slope: Its derivative by the vertices of the T-pose at a fixed level, shape [vertex_count, 3].
    """

    value: float
    level: float
    slope: np.ndarray


@dataclass(frozen=True)
class TapeMeasure:
    """Measure a body in its T-pose, as `rest_body` returns it."""

    body: Body

    @classmethod
    def of(cls, body: Body) -> TapeMeasure:
        """Return a tape measure for a body's fitted model, in whatever pose the body is."""
        return cls(rest_body(body))

    @cached_property
    def edges(self) -> np.ndarray:
        """Return the edges of the mesh, shape [edge_count, 2]."""
        return HalfEdges.of(self.body.rest_faces).edges

    def measure(self, name: str) -> Girth:
        """Measure one of `GIRTHS`."""
        if name == "chest":
            return self.trunk(armpit_height(self.body) - BELOW_ARMPIT)
        if name == "waist":
            return self._best(self.waist_span, least=True)
        if name == "hip":
            return self._best((crotch_height(self.body), float(self.body.joint("pelvis")[1])), least=False)
        if name == "thigh":
            return self.thighs(crotch_height(self.body) - BELOW_CROTCH)
        shoulder, elbow = (self.body.joint(f"left_{joint}")[0] for joint in ("shoulder", "elbow"))
        return self.arms(float(shoulder + BICEPS_POSITION_SHARE * (elbow - shoulder)))

    @property
    def waist_span(self) -> tuple[float, float]:
        """Return the range of heights in which the waist is sought [m]: from the pelvis to below the armpits."""
        return float(self.body.joint("pelvis")[1]), armpit_height(self.body) - BELOW_ARMPIT

    def trunk(self, height: float) -> Girth:
        """Measure the girth of the trunk, or of both legs together, at a height [m], without the arms."""
        centre, shoulder = self.body.joint("pelvis")[0], self.body.joint("left_shoulder")[0]
        section = Section.of(self.body.vertices, self.edges, self.body.rest_faces, 1, height)
        return section.girth(np.abs(section.middles[:, 0] - centre) < abs(shoulder - centre))

    def thighs(self, height: float) -> Girth:
        """Measure the mean girth of both thighs at a height [m] below the crotch."""
        return self._limbs(1, height)

    def arms(self, level: float) -> Girth:
        """Measure the mean girth of both arms at x = level [m] and at the mirrored place."""
        return self._limbs(0, level)

    def _best(self, span: tuple[float, float], least: bool) -> Girth:
        """Return the least or the largest girth of the trunk in a range of heights [m]."""
        found = [self.trunk(height) for height in np.arange(*span, GIRTH_LEVEL_SPACING)]
        values = [girth.value for girth in found]
        return found[int(np.argmin(values) if least else np.argmax(values))]

    def _limbs(self, axis: int, level: float) -> Girth:
        """Return the mean girth of both thighs at a height, or of both arms at a distance from the median plane [m]."""
        body, centre = self.body, float(self.body.joint("pelvis")[0])
        found = []
        for sign in (1.0, -1.0):
            at = level if axis == 1 else centre + sign * (level - centre)
            section = Section.of(body.vertices, self.edges, body.rest_faces, axis, at)
            if axis == 1:
                chosen = sign * (section.middles[:, 0] - centre) > 0.0
            else:
                chosen = np.ones(len(section.middles), dtype=bool)
            found.append(section.girth(chosen))
        return Girth(0.5 * sum(g.value for g in found), level, 0.5 * (found[0].slope + found[1].slope))


@dataclass(frozen=True)
class Section:
    """Describe where a plane cuts the edges of a mesh.

    Attributes:
        ends: Both ends of each cut edge, shape [cut_count, 2].
        share: Position of the cut from the first to the second end, 0 to 1, shape [cut_count].
        part: The connected part of the cut to which each belongs, shape [cut_count].
        middles: Mean of each part's points [m], shape [part_count, 3].
        vertices: Of the mesh [m], shape [vertex_count, 3].
        axis: The axis normal to the plane.
        level: Coordinate of the plane on that axis [m].
    """

    ends: np.ndarray
    share: np.ndarray
    part: np.ndarray
    middles: np.ndarray
    vertices: np.ndarray
    axis: int
    level: float

    @classmethod
    def of(cls, vertices: np.ndarray, edges: np.ndarray, faces: np.ndarray, axis: int, level: float) -> Section:
        """Cut a mesh by the plane normal to an axis (0 to 2) at a level [m]."""
        side = vertices[:, axis] > level
        cut = np.flatnonzero(side[edges[:, 0]] != side[edges[:, 1]])
        ends = edges[cut]
        first, second = vertices[ends[:, 0]], vertices[ends[:, 1]]
        share = (level - first[:, axis]) / (second[:, axis] - first[:, axis])
        points = first + share[:, None] * (second - first)
        # Two cut edges of the same face are connected.
        count = len(vertices)
        key = np.sort(ends, axis=1) @ [count, 1]
        order = np.argsort(key)
        crossed = faces[(side[faces].any(axis=1)) & ~side[faces].all(axis=1)]
        sides = np.sort(np.stack([crossed, crossed[:, [1, 2, 0]]], axis=2), axis=2) @ [count, 1]
        place = np.searchsorted(key[order], sides)
        place = np.minimum(place, max(len(key) - 1, 0))
        hit = key[order][place] == sides if len(key) else np.zeros_like(sides, dtype=bool)
        pairs = order[place[hit]].reshape(-1, 2)
        number, part = find_components(len(cut), pairs[:, 0], pairs[:, 1])
        size = np.maximum(np.bincount(part, minlength=number), 1)
        middles = np.stack([np.bincount(part, points[:, k], number) / size for k in range(3)], axis=1)
        return cls(ends, share, part, middles, vertices, axis, level)

    def girth(self, chosen: np.ndarray) -> Girth:
        """Compute the perimeter of the convex hull of chosen parts, shape [part_count], and its derivative. The hull's
        corners are points p = a + t (b - a) of edges, t = (level - a_y) / (b_y - a_y); at a fixed level, dp = (1 - t)
        da + t db + dt (b - a) with dt = -((1 - t) da_y + t db_y) / (b_y - a_y)."""
        slope = np.zeros_like(self.vertices)
        chosen_faces = np.flatnonzero(chosen[self.part]) if len(self.part) else np.zeros(0, dtype=int)
        if len(chosen_faces) < 3:
            return Girth(float("nan"), self.level, slope)
        flat = [k for k in range(3) if k != self.axis]
        first, second = self.vertices[self.ends[chosen_faces, 0]], self.vertices[self.ends[chosen_faces, 1]]
        share = self.share[chosen_faces, None]
        points = (first + share * (second - first))[:, flat]
        corners = ConvexHull(points).vertices
        ring = points[corners]
        step = np.roll(ring, -1, axis=0) - ring
        length = np.linalg.norm(step, axis=1, keepdims=True)
        unit = step / np.maximum(length, 1e-15)
        by_point = np.zeros((len(corners), 3))
        by_point[:, flat] = np.roll(unit, 1, axis=0) - unit
        along = (second - first)[corners]
        share = share[corners]
        by_share = (by_point * along).sum(axis=1, keepdims=True) / along[:, [self.axis]]
        for end, weight in ((0, 1.0 - share), (1, share)):
            force = weight * by_point
            force[:, [self.axis]] -= weight * by_share
            np.add.at(slope, self.ends[chosen_faces[corners], end], force)
        return Girth(float(length.sum()), self.level, slope)
