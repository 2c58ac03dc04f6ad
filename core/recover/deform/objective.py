"""Compute the loss of the deformation (thesis eq. 4.2 to 4.7) as a torch function of the node positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from scipy.spatial import cKDTree
from torch.nn.functional import normalize

from ...body.exposed import ExposedSurface
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import vertex_areas
from ...geometry.surface import ClosestPoints, TriangleSurface
from .contour_match import ContourMatch, CurveRows
from .rest_metric import RestMetric
from .settings import DeformSettings
from .target_repair import PreparedTarget

BODY_REACH = 0.02
"""Distance to the body within which a node enters the body term [m]: more than it moves between two updates."""

BODY_SEARCH_INTERVAL = 5
"""Number of searches for matches (ten iterations) between two exact distances to the body. In between the body is a
plane at the closest point of each node, which moves by less than the curvature of a body allows."""


MAX_VERTICES_PER_NODE = 3
"""Number of target vertices for each node above which the vertices are thinned out: further vertices add no information
on a node's place, and their matches take most of the time. The polish uses all of them."""


@dataclass(frozen=True)
class Matches:
    """Describe the correspondences of one iteration; all are constant for the derivative.

    Attributes:
        to_target: Closest point on the target of each node.
        to_source: Closest point on the garment of each target vertex.
        source_share: Weight of each node, 0 where it covers a hole.
        contours: Rows of the matched contours.
        body: Nodes near the body, directions out of it, and heights [m] of its tangent planes along them.
    """

    to_target: ClosestPoints
    to_source: ClosestPoints
    source_share: np.ndarray
    contours: CurveRows | None
    body: tuple[np.ndarray, np.ndarray, np.ndarray] | None


class Objective:
    """Evaluate a garment's nodes against the target, the body and the garment's own rest shape."""

    def __init__(
        self,
        nodes: np.ndarray,
        faces: np.ndarray,
        inverse_rest: np.ndarray,
        areas: np.ndarray,
        target: PreparedTarget,
        body: ExposedSurface,
        settings: DeformSettings,
    ) -> None:
        self._settings = settings
        self._target = target
        self._body = body
        self._array_faces = np.ascontiguousarray(faces, dtype=np.int64)
        self._faces = torch.from_numpy(self._array_faces)
        self._inverse = torch.from_numpy(inverse_rest)
        self._areas = torch.from_numpy(areas)
        edges = HalfEdges.of(faces)
        first, _ = edges.pairs.T
        hinges = np.column_stack([edges.tail[first], edges.head[first], edges.pairs // 3])
        self._hinges = torch.from_numpy(hinges)
        share = vertex_areas(nodes, faces)
        self._share = share / share.sum()
        picked, shares = np.arange(len(target.shares)), target.shares
        if settings.distance == "surface" and len(picked) > MAX_VERTICES_PER_NODE * len(nodes):
            picked, shares = subsample_by_grid(
                target.surface.vertices, shares, float(np.sqrt(share.sum() / len(nodes)))
            )
        self._goal = torch.from_numpy(target.surface.vertices[picked])
        self._goal_normals = torch.from_numpy(np.ascontiguousarray(target.normals[picked]))
        self._goal_share = torch.from_numpy(shares)
        self._curves = ContourMatch(target.pairs, nodes, target.surface.vertices)
        self._near: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        self._searches = 0

    def match(self, nodes: np.ndarray) -> Matches:
        """Find the correspondences of the current nodes [m], shape [node_count, 3]."""
        target = self._target
        self._watch_body(nodes)
        if self._settings.distance == "vertices":
            to_target = _nearest_vertices(nodes, target.surface.vertices, target.surface.faces)
            to_source = _nearest_vertices(target.surface.vertices, nodes, self._array_faces)
            return Matches(to_target, to_source, self._share, self._curves.rows(nodes), self._near)
        to_target = target.surface.closest(nodes)
        to_source = TriangleSurface(nodes, self._array_faces).closest(self._goal.numpy())
        share = np.where(target.on_rim(to_target), 0.0, self._share)
        return Matches(to_target, to_source, share, self._curves.rows(nodes), self._near)

    def terms(self, x: torch.Tensor, matches: Matches, stretch: RestMetric, strain: bool) -> dict[str, torch.Tensor]:
        """Evaluate every weighted term at the nodes x [m], shape [node_count, 3]."""
        settings = self._settings
        corner = x[self._faces]
        first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        normal = torch.linalg.cross(first, second)
        terms = self._data(x, normal, matches)
        if matches.contours is not None and settings.contour > 0:
            terms["contour"] = settings.contour * self._contour(x, matches.contours)
        if settings.bending > 0:
            terms["bending"] = settings.bending * self._bending(x, normal)
        if strain and settings.strain > 0:
            terms["strain"] = settings.strain * self._strain(first, second, stretch)
        if settings.body > 0 and matches.body is not None:
            terms["body"] = settings.body * self._collision(x, matches.body)
        return terms

    def _data(self, x: torch.Tensor, normal: torch.Tensor, matches: Matches) -> dict[str, torch.Tensor]:
        """Return distances both ways (eq. 3.8 or to the surface) and the cosine distance of normals (eq. 4.3)."""
        faces = self._target.surface.faces
        foot = torch.from_numpy(matches.to_target.foot)
        foot_normal = torch.from_numpy(matches.to_target.interpolate(self._target.normals, faces))
        foot_normal = normalize(foot_normal, dim=1, eps=1e-12)
        index = self._faces[torch.from_numpy(matches.to_source.face)]
        weights = torch.from_numpy(matches.to_source.barycentric)[..., None]
        vertex_normal = torch.zeros_like(x).index_add(0, self._faces.reshape(-1), normal.repeat_interleave(3, 0))
        vertex_normal = normalize(vertex_normal, dim=1, eps=1e-12)
        cover = (x[index] * weights).sum(1)
        cover_normal = normalize((vertex_normal[index] * weights).sum(1), dim=1, eps=1e-12)
        share = torch.from_numpy(matches.source_share)
        squared = ((x - foot) ** 2).sum(1)
        back = ((cover - self._goal) ** 2).sum(1)
        cosine = (vertex_normal * foot_normal).sum(1)
        cosine_back = (cover_normal * self._goal_normals).sum(1)
        if self._target.unsigned:
            cosine, cosine_back = cosine.abs(), cosine_back.abs()
        turned = (share * (1 - cosine)).sum() + (self._goal_share * (1 - cosine_back)).sum()
        if self._settings.reduction == "sum":
            distance = squared.sum() + back.sum()
        else:
            distance = (share * squared).sum() + (self._goal_share * back).sum()
        return {"distance": distance, "normal": self._settings.normal * turned}

    def _contour(self, x: torch.Tensor, rows: CurveRows) -> torch.Tensor:
        """Return the mean squared distance between matched contours, both directions (second term of eq. 4.2)."""
        along = torch.from_numpy(rows.along)[:, None]
        points = x[torch.from_numpy(rows.first)] * (1 - along) + x[torch.from_numpy(rows.second)] * along
        squared = ((points - torch.from_numpy(rows.goal)) ** 2).sum(1)
        if self._settings.reduction == "sum":
            return squared.sum()
        return (squared * torch.from_numpy(rows.share)).sum()

    def _bending(self, x: torch.Tensor, normal: torch.Tensor) -> torch.Tensor:
        """Return the sum of k / 2 alpha^2 over inner edges (eq. 4.4), alpha the angle between the faces' normals."""
        unit = normalize(normal, dim=1, eps=1e-12)
        one, other = unit[self._hinges[:, 2]], unit[self._hinges[:, 3]]
        axis = normalize(x[self._hinges[:, 1]] - x[self._hinges[:, 0]], dim=1, eps=1e-12)
        angle = torch.atan2((torch.linalg.cross(one, other) * axis).sum(1), (one * other).sum(1))
        return 0.5 * self._settings.bending_stiffness * (angle**2).sum()

    def _strain(self, first: torch.Tensor, second: torch.Tensor, metric: RestMetric) -> torch.Tensor:
        """Return the sum of A (lambda / 2 tr(E)^2 + mu tr(E^2)) (eq. 4.5), E the Green strain on the rest stretch."""
        undo = torch.from_numpy(metric.undo)
        gradient = torch.stack([first, second], 2) @ self._inverse @ undo
        green = 0.5 * (gradient.transpose(1, 2) @ gradient - torch.eye(2, dtype=gradient.dtype))
        trace = green[:, 0, 0] + green[:, 1, 1]
        settings = self._settings
        density = 0.5 * settings.lame_lambda * trace**2 + settings.lame_mu * (green**2).sum((1, 2))
        return (density * self._areas).sum()

    def _watch_body(self, nodes: np.ndarray) -> None:
        """Update the planes of the body at the nodes near it, every `BODY_SEARCH_INTERVAL` searches."""
        if self._searches % BODY_SEARCH_INTERVAL == 0 and self._settings.body > 0:
            distance, out = self._body.measure(nodes)
            watched = np.flatnonzero(distance < BODY_REACH)
            height = (out[watched] * nodes[watched]).sum(1) - distance[watched]
            self._near = (watched, out[watched], height) if len(watched) else None
        self._searches += 1

    def _collision(self, x: torch.Tensor, planes: tuple[np.ndarray, np.ndarray, np.ndarray]) -> torch.Tensor:
        """Return the cubed shortfalls from the margin (eq. 4.6), mean over the area, or sum over nodes."""
        points, out, height = (torch.from_numpy(part) for part in planes)
        missing = torch.relu(self._settings.body_margin + height - (x[points] * out).sum(1)) ** 3
        if self._settings.reduction == "sum":
            return missing.sum()
        return (missing * torch.from_numpy(self._share)[points]).sum()


def subsample_by_grid(vertices: np.ndarray, shares: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of one vertex [m] in each cell of a grid [m], and the summed shares of each cell."""
    cells = np.floor((vertices - vertices.min(axis=0)) / width).astype(np.int64)
    _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    return first, np.bincount(cell.reshape(-1), weights=shares)


def _nearest_vertices(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> ClosestPoints:
    """Return each point's nearest vertex as a point of one of its faces."""
    distance, nearest = cKDTree(vertices).query(points)
    face_of = np.zeros(len(vertices), dtype=np.int64)
    face_of[faces] = np.arange(len(faces))[:, None]
    face = face_of[nearest]
    corner = (faces[face] == nearest[:, None]).astype(np.float64)
    return ClosestPoints(vertices[nearest], face, corner, distance)
