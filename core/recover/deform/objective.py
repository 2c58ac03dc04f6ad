"""Evaluate the loss of the deformation (thesis eq. 4.2 to 4.7) and its gradient by the node positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...body.exposed import ExposedSurface
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import unit, vertex_areas
from ...geometry.surface import ClosestPoints, TriangleSurface
from .contour_match import ContourMatch
from .data_terms import PointRows, cosine_distances, pull_back_normals, squared_distances, unit_normals
from .rest_metric import RestMetric
from .settings import DeformSettings
from .shape_terms import body_depth, fold_energy, strain_energy
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
        to_target: Nodes, and their closest points on the target.
        to_source: Closest points on the garment of the target's vertices, and these.
        facing_target: Nodes, and the target's normals at the closest points; weights are 0 where a node covers a hole.
        facing_source: Closest points on the garment, and the normals of the target's vertices.
        contours: Rows of the matched contours.
        body: Nodes near the body, directions out of it, heights [m] of its tangent planes along them, and weights.
    """

    to_target: PointRows
    to_source: PointRows
    facing_target: PointRows
    facing_source: PointRows
    contours: PointRows | None
    body: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None


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
        self._faces = faces
        self._surface = TriangleSurface(nodes, target.shown_faces)
        self._inverse, self._areas = np.ascontiguousarray(inverse_rest), areas
        edges = HalfEdges.of(faces)
        first, second = edges.pairs.T
        hinges = (edges.tail[first], edges.head[first], edges.opposite[first], edges.opposite[second])
        self._hinges = np.stack(hinges, axis=1)
        share = vertex_areas(nodes, target.shown_faces)
        self._share = share / share.sum()
        picked, shares = np.arange(len(target.shares)), target.shares
        if settings.distance == "surface" and len(picked) > MAX_VERTICES_PER_NODE * len(nodes):
            picked, shares = subsample_by_grid(
                target.surface.vertices, shares, float(np.sqrt(share.sum() / len(nodes)))
            )
        self._goal = target.surface.vertices[picked]
        self._goal_normals = target.normals[picked]
        self._goal_share = shares
        self._curves = ContourMatch(target.pairs, nodes, target.surface.vertices)
        self._near: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None = None
        self._found: tuple[np.ndarray | None, np.ndarray | None] = (None, None)
        self._searches = 0

    def match(self, nodes: np.ndarray) -> Matches:
        """Find the correspondences of the current nodes [m], shape [node_count, 3]."""
        target, share = self._target, self._share
        self._watch_body(nodes)
        if self._settings.distance == "vertices":
            to_target = _nearest_vertices(nodes, target.surface.vertices, target.surface.faces)
            to_source = _nearest_vertices(target.surface.vertices, nodes, self._surface.faces)
        else:
            self._surface = self._surface.moved(nodes)
            to_target = target.surface.closest(nodes, self._found[0])
            to_source = self._surface.closest(self._goal, self._found[1])
            self._found = (to_target.face, to_source.face)
            share = np.where(target.on_rim(to_target), 0.0, share)
        normals = unit(to_target.interpolate(target.normals, target.surface.faces))
        own = np.arange(len(nodes))[:, None], np.ones((len(nodes), 1))
        covered = self._surface.faces[to_source.face], to_source.barycentric
        contours = self._curves.rows(nodes)
        return Matches(
            PointRows(*own, to_target.foot, self._reduce(share)),
            PointRows(*covered, self._goal, self._reduce(self._goal_share)),
            PointRows(*own, normals, share),
            PointRows(*covered, self._goal_normals, self._goal_share),
            None if contours is None else contours._replace(weights=self._reduce(contours.weights)),
            self._near,
        )

    def evaluate(
        self, nodes: np.ndarray, matches: Matches, metric: RestMetric, strain: bool
    ) -> tuple[dict[str, float], np.ndarray]:
        """Evaluate every weighted term at the nodes [m], shape [node_count, 3].

        Args:
            nodes: Positions.
            matches: The correspondences.
            metric: Rest stretch of the strain.
            strain: Whether strain counts already.

        Returns:
            The terms by name, and the gradient of their sum, shape [node_count, 3].
        """
        settings, faces, gradient = self._settings, self._faces, np.zeros_like(nodes)
        terms = {
            "distance": squared_distances(nodes, matches.to_target, 1.0, gradient)
            + squared_distances(nodes, matches.to_source, 1.0, gradient),
            "normal": self._compare_normals(nodes, matches, gradient),
        }
        if matches.contours is not None and settings.contour > 0:
            terms["contour"] = squared_distances(nodes, matches.contours, settings.contour, gradient)
        if settings.bending > 0:
            terms["bending"] = fold_energy(nodes, self._hinges, settings.bending * settings.bending_stiffness, gradient)
        if strain and settings.strain > 0:
            rest, lame = (self._inverse, metric.undo, self._areas), (settings.lame_lambda, settings.lame_mu)
            terms["strain"] = strain_energy(nodes, faces, rest, lame, settings.strain, gradient)
        if settings.body > 0 and matches.body is not None:
            terms["body"] = body_depth(nodes, matches.body, settings.body_margin, settings.body, gradient)
        return terms, gradient

    def _compare_normals(self, nodes: np.ndarray, matches: Matches, gradient: np.ndarray) -> float:
        """Return the weighted cosine distances of normals, both ways (eq. 4.3), and add their gradient."""
        faces, scale, unsigned = self._surface.faces, self._settings.normal, self._target.unsigned
        normals, lengths, slopes = np.zeros_like(nodes), np.zeros(len(nodes)), np.zeros_like(nodes)
        unit_normals(nodes, faces, normals, lengths)
        turned: float = cosine_distances(normals, matches.facing_target, scale, unsigned, slopes)
        turned += cosine_distances(normals, matches.facing_source, scale, unsigned, slopes)
        pull_back_normals(nodes, faces, (normals, lengths), slopes, gradient)
        return turned

    def _reduce(self, shares: np.ndarray) -> np.ndarray:
        """Return the weights of rows with these shares: the shares for a mean, ones for a sum."""
        return np.ones_like(shares) if self._settings.reduction == "sum" else shares

    def _watch_body(self, nodes: np.ndarray) -> None:
        """Update the planes of the body at the nodes near it, every `BODY_SEARCH_INTERVAL` searches."""
        if self._searches % BODY_SEARCH_INTERVAL == 0 and self._settings.body > 0:
            distance, out = self._body.measure(nodes)
            watched = np.flatnonzero(distance < BODY_REACH)
            height = (out[watched] * nodes[watched]).sum(1) - distance[watched]
            weights = self._reduce(self._share[watched])
            self._near = (watched, out[watched], height, weights) if len(watched) else None
        self._searches += 1


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
