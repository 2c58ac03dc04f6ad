"""Register a draped template coarsely to the target: contour to contour, surface to surface, smooth in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...garment.garment import Garment
from ...geometry.connectivity import HalfEdges, find_components
from ...geometry.curves import Curve
from ...geometry.geometry import (
    bending_matrix,
    cotangent_laplacian,
    gradient_operator,
    lump,
    signed_areas,
    vertex_normals,
)
from ...geometry.linear import analyse_pattern, factor_symmetric
from ...geometry.rim import Rim
from ...geometry.surface import ClosestPoints, TriangleSurface
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.target import Target
from .armpits import Armpits
from .parts import find_parts


@dataclass(frozen=True)
class HiddenCloth:
    """Describe how hidden cloth follows the visible cloth.

    Attributes:
        even: Length [m] above which a displacement is even rather than smooth: 5 cm, two edges of the mesh, joins the
            visible part smoothly and keeps lengths over any hidden part of relevant size.
        rest: Length [m] to which cloth resting on the body, below the crotch or on a shoulder, keeps its place relative
            to the cloth around it: 5 cm, less than the way between two supports.
        level: Share of the vertical in its normal from which cloth rests: nearer to level than to upright.
    """

    even: float = 0.05
    rest: float = 0.05
    level: float = 0.7

    def stiffness(self, garment: Garment, chosen: np.ndarray) -> sp.csr_matrix:
        """Return the matrix of int (|grad d|^2 + s |d|^2 / h^2) dA / l^2, shape [node_count, node_count].

        Notation: l `even`, h `rest`; s 1 where cloth rests on the body, else 0.

        Args:
            garment: The garment on the wearer; integrals run over its flat rest shape.
            chosen: True at the nodes that are hidden, shape [node_count]; faces count by their share of these corners.
        """
        uneven, area = dirichlet_operator(garment, chosen)
        rests = np.abs(vertex_normals(garment.nodes, garment.faces)[:, 1]) > self.level
        return sp.csr_matrix((uneven + sp.diags(area * rests) / self.rest**2) / self.even**2)


@dataclass(frozen=True)
class RegistrationSettings:
    """Describe the coarse registration.

    Attributes:
        steps: Number of solves; each takes one closest-point query each way. 40 let matches settle between two reaches.
        reach_first, reach_last: Length [m] below which displacements are smoothed, at the first and the last step: from
            half a torso, so that garments slide over each other as a whole, to half a fold; that reduced the panels'
            area error on five garments from 16 % (at 4 cm) to 13 %.
        contour_reach: The same for matched contours [m]: 5 mm, they fit almost exactly.
        facing: Cosine to which both normals agree for a closest point to count; 0.3 keeps folds, not the other leg.
        across_seams: Cost of a kink of the displacement at a seam between parts of the garment, such as sleeve and body
            or top and skirt, as a share of that within a part. Each part is graded in its own proportion: a sleeve
            twice as long must not move the shoulder. A thousandth halves the error of the panels' areas on five
            garments, from 7 to 3.5 %, and that of their outlines from 21 to 15 mm; a hundredth achieves half of that.
        samples: Largest number of target vertices that are matched to the source; as many as a garment mesh has.
        even: `HiddenCloth.even` [m] beyond the target's end at an open curve without a matched contour. Extrapolated
            instead, the end of a sleeve became a spike. With 15 cm a skirt whose hem is cut off takes a little more of
            the scan's flare, and crumpled cuffs are off by twice as much.
        hidden: How cloth beyond a hidden border follows the cloth at it; None: it stays where it is.
    """

    steps: int = 40
    reach_first: float = 0.30
    reach_last: float = 0.015
    contour_reach: float = 0.005
    facing: float = 0.3
    across_seams: float = 0.001
    samples: int = 3000
    even: float = 0.05
    hidden: HiddenCloth | None = None


def register_coarsely(
    garment: Garment,
    target: Target,
    settings: RegistrationSettings | None = None,
    hooks: Hooks = SILENT_HOOKS,
    armpits: Armpits | None = None,
) -> np.ndarray:
    """Move the nodes of a draped template onto the target [m], shape [node_count, 3].

    Each step minimises over the displacement d
        int |lap d|^2 dA + (int |d - q|^2 dA + int |x + d - t|^2 dT) / r^4 + int_contours |d - q_c|^2 / r_c^3 ds

    Notation: r `reach`, r_c `contour_reach`; q from each node x to the plane of its closest point on the target; t
    target points, each matched to the point of the garment closest to it; q_c from each contour node to the point at
    the same share of the target contour's length.

    Integrals over the garment run over its flat rest shape, so that the result does not depend on the mesh. Beyond a
    hidden border `HiddenCloth` makes d even, so that the cloth keeps its lengths; so does int |grad d|^2 dA / `even`^2
    beyond the target's end at an open curve that is not pinned. Cloth that `armpits` hide has no closest points; its
    `tied` nodes are drawn to where they are worn.
    """
    settings = settings or RegistrationSettings()
    start = garment.nodes
    stiffness, mass = bending_operators(garment, settings.across_seams)
    pins, pinned = _pin_contours(garment, target, settings)
    hidden, stays = np.zeros((2, len(start)), dtype=bool) if armpits is None else (armpits.hidden, armpits.fixed)
    hidden, shown = hidden & (pins == 0), ~hidden[garment.faces].all(axis=1)
    goal = TriangleSurface(target.vertices, target.faces)
    picked = np.linspace(0, len(goal.vertices) - 1, min(settings.samples, len(goal.vertices))).astype(np.int64)
    # The picked points stand for the whole target, weighted so that it has the garment's area.
    share = goal.vertex_areas[picked] * (mass.sum() / goal.vertex_areas[picked].sum())
    # A hundredth of the first pull to stay in place: the system keeps full rank where nothing is matched at all.
    fixed = stiffness + sp.diags(pins + 0.01 * mass / settings.reach_first**4)
    # The bending couples two rings around a node, all else one.
    edges = HalfEdges.of(garment.faces, len(start))
    solver = analyse_pattern(edges, rings=2)
    moved, surface = start.copy(), TriangleSurface(start, garment.faces)
    rim = None if settings.hidden is None or target.hidden is None else Rim.between(goal.faces, target.hidden)
    rims = [line.vertices for line in garment.contours if not pins[line.vertices].any()]
    free = np.concatenate([np.zeros(0, dtype=np.int64), *rims])
    for step, reach in enumerate(np.geomspace(settings.reach_first, settings.reach_last, settings.steps)):
        hooks.progress("grade", 0.8 * step / settings.steps, "registering")
        surface = surface.moved(moved)
        found, seen = match_surface(goal, moved, surface.vertex_normals, settings.facing)
        out = goal.normals_at(found)
        weight = np.where(seen & (pins == 0) & ~hidden, mass, 0.0) / reach**4
        # Nodes without a match stay about in place; otherwise they would be extrapolated far out.
        stillness = np.where(seen | (pins > 0) | hidden, 0.0, mass) / reach**4
        tied = fixed
        if rim is not None and settings.hidden is not None:
            beyond = rim.is_ahead(goal, found)
            weight, stillness = np.where(beyond, 0.0, weight), np.where(beyond, 0.0, stillness)
            tied = fixed + settings.hidden.stiffness(garment, beyond)
        beyond = _find_reachable(free, stillness > 0.0, edges.edges)
        if beyond.any():
            stillness = np.where(beyond, 0.0, stillness)
            tied = tied + dirichlet_operator(garment, beyond)[0] / settings.even**2
        lead = moved - start + out * (out * (found.foot - moved)).sum(1)[:, None]
        found, seen = match_surface(surface, goal.vertices[picked], goal.vertex_normals[picked], settings.facing)
        on_faces = found.interpolation(surface.faces, len(moved))
        pull = np.where(seen, share, 0.0) / reach**4
        pull[~shown[found.face]] = 0.0
        stay = np.where(hidden & stays, mass, 0.0) / reach**4
        system = tied + sp.diags(weight + stillness + stay) + on_faces.T @ sp.diags(pull) @ on_faces
        right = weight[:, None] * lead + stillness[:, None] * (moved - start) + pins[:, None] * pinned
        right += on_faces.T @ (pull[:, None] * (goal.vertices[picked] - on_faces @ start))
        moved = start + factor_symmetric(system, solver).solve(right)
    return moved


def _pin_contours(garment: Garment, target: Target, settings: RegistrationSettings) -> tuple[np.ndarray, np.ndarray]:
    """Return each node's weight to its matched contour, [node_count], and displacement there [m], [node_count, 3]."""
    pins, pinned = np.zeros(len(garment.nodes)), np.zeros((len(garment.nodes), 3))
    for contour in garment.contours:
        other = target.contour(contour.name)
        if other is not None and contour.trusted and other.trusted:
            place, share = match_curve(contour.curve(garment.nodes), other.curve(target.vertices))
            np.add.at(pins, contour.vertices, share / settings.contour_reach**3)
            pinned[contour.vertices] = place - garment.nodes[contour.vertices]
    return pins, pinned


def _find_reachable(ends: np.ndarray, passable: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return which passable nodes the edges join to end nodes by passable ones, bool, shape [node_count]."""
    ends = ends[passable[ends]]
    if not len(ends):
        return np.zeros(len(passable), dtype=bool)
    _, piece = find_components(len(passable), *edges[passable[edges].all(axis=1)].T)
    return passable & np.isin(piece, piece[ends])


def match_surface(
    surface: TriangleSurface, points: np.ndarray, normals: np.ndarray, facing: float
) -> tuple[ClosestPoints, np.ndarray]:
    """Find closest points, and whether each counts: not at an open edge, where the surface ends, and normals agree."""
    found = surface.closest(points)
    alike = (surface.normals_at(found) * normals).sum(1) > facing
    return found, alike & ~surface.border_faces[found.face]


def match_curve(source: Curve, target: Curve, samples: int = 128) -> tuple[np.ndarray, np.ndarray]:
    """Match two curves by their share of length, of closed ones from the best common start.

    Both run with the garment on the left; only the start is free: of `samples` the one of least squared distance. Open
    ones begin and end at the same corners.

    Returns:
        Points on the target [m], shape [source_count, 3], and the length [m] that each source point stands for.
    """
    shares, start = source.arc[: len(source.points)] / source.length, 0.0
    if source.is_closed:
        grid = np.arange(samples) / samples
        a, b = source.at_shares(grid), target.at_shares(grid)
        a, b = a - a.mean(0), b - b.mean(0)
        costs = [((a - np.roll(b, -shift, axis=0)) ** 2).sum() for shift in range(samples)]
        start = int(np.argmin(costs)) / samples
    return target.at_shares(shares + start), source.corner_lengths


def dirichlet_operator(garment: Garment, chosen: np.ndarray) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return the matrix of int |grad d|^2 dA, [node_count, node_count], and node areas [m2], of a part of a garment.

    Args:
        garment: The garment; integrals run over its flat rest shape.
        chosen: True at the nodes of the part, shape [node_count]; faces count by their share of these corners.
    """
    count = len(garment.nodes)
    gradient, area = gradient_operator(garment.rest, garment.faces, count)
    area = area * chosen[garment.faces].mean(1)
    return sp.csr_matrix(gradient.T @ sp.diags(np.repeat(area, 2)) @ gradient), lump(area, garment.faces, count)


def bending_operators(garment: Garment, across: float = 1.0) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return the matrix of int |lap d|^2 dA over the flat rest shape, [node_count, node_count], and node areas [m2].

    L^T M^-1 L with the cotangent Laplacian L and the lumped areas M; the share `across` of it over the sewn garment,
    the rest over its parts, between which the displacement may kink. Rows of nodes on open contours, or on the rim of a
    part, are left out, so that a displacement that grows linearly towards them costs nothing.

    Args:
        garment: The garment.
        across: Cost of a kink at a seam between parts, as a share of its cost elsewhere.
    """
    sewn, mass = _bending(garment.rest, garment.faces, len(garment.nodes))
    part = find_parts(garment.pattern)
    ids, vertex = np.unique(part[garment.panel_of_uv] * len(garment.nodes) + garment.uv_node, return_inverse=True)
    parts, _ = _bending(garment.rest, vertex[garment.uv_faces], len(ids))
    node = sp.csr_matrix((np.ones(len(ids)), (np.arange(len(ids)), ids % len(garment.nodes))), (len(ids), len(mass)))
    return sp.csr_matrix(across * sewn + (1.0 - across) * (node.T @ parts @ node)), mass


def _bending(corners: np.ndarray, faces: np.ndarray, count: int) -> tuple[sp.csr_matrix, np.ndarray]:
    laplacian = cotangent_laplacian(corners, faces, count)
    mass = lump(np.abs(signed_areas(corners)), faces, count)
    weight = np.where(HalfEdges.of(faces, count).border_vertices, 0.0, 1.0 / mass)
    return bending_matrix(laplacian, weight), mass
