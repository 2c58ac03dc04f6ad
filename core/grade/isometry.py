"""Panels and the cloth on a surface, isometric to each other: one linear system for nodes and control points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from ..body import Body
from ..mesh import ClosedCurve, HalfEdges, TriangleSurface, gradient_operator, lump
from ..pattern import Garment, Pattern, find_symmetry, map_controls
from ..segment import Target, name_contours
from .armpits import Armpits
from .flattening import narrow_panels, seam_rows, solve_sewn
from .grading import GradeSettings, move_pattern, step_without_folds
from .proportion import Proportions, find_proportions
from .registration import match_surface

if TYPE_CHECKING:
    from ..simulate import BlockPattern, Solver


@dataclass(frozen=True)
class IsometrySettings:
    """Set the joint fit of pattern and place.

    Attributes:
        vertices: Vertices of its mesh; 1000 have edges of 3 cm, and a step takes 0.3 s. Seams move as a whole.
        steps: Steps; the slowest motion, of a waist seam towards the waist, is most of its way after 24.
        surface: A node that is this far from the target's tangent plane [m] costs as much per area as a strain of 1.
            4 mm keeps nodes on the surface and lets a fold be cut short.
        border: The same for a node on an open contour, across the contour [m].
        along: Share of that cost for sliding along the contour, which is not seen.
        reach: Damping: a motion of this many metres in one step costs as much as a strain of 1. It only has to be
            there where nothing else holds a node.
        proportion: Cost of one standard deviation of a rule of `Proportions`, by the garment's area: as much as a
            strain of 3 % everywhere, which is what unlike cloth and folds leave.
        believed: Strain up to which a drape's cloth is believed: beyond a tenth lie bad triangles. Where a garment
            hangs from its neck, or is tight, it strains by more than the 3 % of cloth that hangs free: clipped to 3 %,
            panels of ten garments are 2.7 % off in area, to 10 % 2.4 %, to 30 % 2.5 %.
        facing: As in the coarse registration.
        keep: Damping of the control points, relative to the mean diagonal of their matrix.
        stay: Cost by area of a panel's strain from where the fit began; 0 lets panels go wherever isometry leads.
        stay_band: The same for panels narrower than 12 cm.
        stay_hidden: The same for faces at nodes that a hanging arm hides where a sleeve begins, or next to them; where
            it is not 0 these nodes are not held in place but go where their panels lead them. A drape sags in the
            armpit, and lengths measured from there are wrong by as much.
    """

    vertices: int = 1000
    steps: int = 24
    surface: float = 0.004
    border: float = 0.002
    along: float = 0.05
    reach: float = 3.0
    proportion: float = 0.001
    believed: float = 0.10
    facing: float = 0.3
    keep: float = 1e-4
    stay: float = 0.0
    stay_band: float = 0.0
    stay_hidden: float = 0.0


@dataclass(frozen=True)
class Isometry:
    """Describe what stays the same from step to step.

    Minimises over the nodes x and the effective control points c at once

        sum_f A_f |F_f - R_f U_f J_f|^2 + sum_v a_v (n_v . (x_v - q_v))^2 / l^2 + contours + w A sum_k r_k^2
        + sum_f b_f A_f |J_f G_f - I|^2

    For fixed rotations R_f it is one linear system; the nodes are eliminated from it. Seams stay equal to first order
    and are equalised after each step.

    Notation: F_f the map from face f's present flat shape to 3D, J_f the map to its new flat shape, linear in c;
    U_f the strain that the cloth has on the target; q_v, n_v closest point and normal on the target, l `surface`; r_k
    what the rules of `Proportions` miss, w `proportion`, A the garment's area; J_f G_f the map from the flat shape at
    the start, b_f `stay`, `stay_band` or `stay_hidden`.

    Attributes:
        goal: The target.
        hidden: Nodes between the trunk and a hanging arm, which stay where they are, shape [node_count].
        loose: Nodes that `stay_hidden` leaves free, shape [node_count]; none of them is `hidden`.
        borders: Nodes of each open contour, and the target's contour or, where it is not trusted, their own place [m].
        strain: U, shape [face_count, 2, 2].
        free: Control points (x0, y0, ...) by effective ones, shape [2 point_count, effective_count].
        proportions: Rules to keep.
        start: Control points at the start [m], shape [point_count, 2].
        anchor: Matrix of the last sum, shape [effective_count, effective_count].
        coupled: Which nodes share a face or a hinge.
        solver: Analysed for it.
        settings: How.
    """

    goal: TriangleSurface
    hidden: np.ndarray
    loose: np.ndarray
    borders: tuple[tuple[np.ndarray, ClosedCurve], ...]
    strain: np.ndarray
    free: np.ndarray
    proportions: Proportions
    start: np.ndarray
    anchor: np.ndarray
    coupled: BlockPattern
    solver: Solver
    settings: IsometrySettings

    @classmethod
    def of(
        cls,
        garment: Garment,
        target: Target,
        body: Body,
        like: Pattern,
        strain: np.ndarray,
        settings: IsometrySettings,
    ) -> Isometry:
        """Prepare the fit of a garment whose nodes lie on the target.

        Args:
            garment: The mesh to start from.
            target: The scan's surface with named contours.
            body: The wearer, on whom the contours are named.
            like: The template: tells symmetry and proportions.
            strain: U of each face, shape [face_count, 2, 2].
            settings: How.
        """
        from ..simulate import BlockPattern, make_solver

        borders = []
        for contour in name_contours(garment.nodes, garment.faces, body)[0]:
            other = target.contour(contour.name)
            # Where none is to be trusted it stays where registration left it: panels that end nowhere would shrink.
            loop = garment.nodes[contour.vertices]
            if other is not None and other.trusted:
                loop = target.vertices[other.vertices]
            borders.append((contour.vertices, ClosedCurve(loop)))
        armpits = Armpits.of(garment, body)
        hidden, loose = armpits.hidden, np.zeros_like(armpits.hidden)
        if settings.stay_hidden > 0.0 and armpits.held.any():
            loose[garment.faces[hidden[garment.faces].any(axis=1)]] = True  # beside them lies what scans have instead
        on_border = [node for line, _ in borders for node in line]
        hidden[on_border] = loose[on_border] = False
        hidden &= ~loose
        free = find_symmetry(like).matrix.toarray()
        # faces alone couple nodes; with the hinges, whose blocks stay zero, elimination keeps its order and round-off
        hinges = HalfEdges.of(garment.faces, len(garment.nodes)).hinge_vertices
        coupled, _ = BlockPattern.of(len(garment.nodes), garment.faces, hinges)
        return cls(
            goal=TriangleSurface(target.vertices, target.faces),
            hidden=hidden,
            loose=loose,
            borders=tuple(borders),
            strain=strain,
            free=free,
            proportions=find_proportions(like),
            start=garment.pattern.points,
            anchor=_anchor(garment, free, loose, settings),
            coupled=coupled,
            solver=make_solver(coupled),
            settings=settings,
        )

    def step(self, garment: Garment) -> Garment:
        """Solve once for nodes and control points with the rotations as they are."""
        on_uv, area = gradient_operator(garment.rest, garment.uv_faces, len(garment.uv))
        weight = np.repeat(area, 2)
        gradient = sp.csr_matrix(on_uv @ _uv_of_nodes(garment))
        wanted = self._turned_strain(gradient, garment.nodes)
        moved = self._move_flat(garment, on_uv, wanted)
        count, parameters = len(garment.nodes), self.free.shape[1]
        # Rows of a face: (d/dx, d/dy) of the three coordinates.
        target_rows = np.swapaxes(wanted, 1, 2)
        held, pulled = self._hold_on_target(garment, area)
        self._factor(sp.csr_matrix(gradient.T @ sp.diags(weight) @ gradient), held)
        weighted = weight.reshape(-1, 2, 1, 1) * moved
        coupling = (gradient.T @ weighted.reshape(len(weight), -1)).reshape(3 * count, parameters)
        load = gradient.T @ (weight[:, None] * target_rows.reshape(-1, 3))
        start, follow = self.solver.solve((load + pulled).ravel()), self.solver.solve(coupling)
        flat = moved.reshape(-1, parameters)
        matrix = flat.T @ weighted.reshape(-1, parameters) - coupling.T @ follow
        right = coupling.T @ start - weighted.reshape(-1, parameters).T @ target_rows.ravel()
        change = self._solve_pattern(garment.pattern, matrix, right, float(area.sum()))
        points = garment.pattern.points + (self.free @ change).reshape(-1, 2)
        pattern, share = step_without_folds(garment.pattern, points, GradeSettings())
        nodes = (start + share * (follow @ change)).reshape(-1, 3)
        return move_pattern(garment, pattern).at(nodes)

    def _factor(self, stiffness: sp.csr_matrix, held: np.ndarray) -> None:
        """Factor the nodes' matrix: a stiffness [n, n] that all coordinates share, and a block [3, 3] of each node."""
        pairs = np.asarray(stiffness[self.coupled.rows, self.coupled.columns]).ravel()
        blocks = pairs[:, None, None] * np.eye(3)
        blocks[self.coupled.diagonal] += held
        if not self.solver.factor(self.coupled.assemble(blocks)):
            raise np.linalg.LinAlgError("the cloth on the target is not held everywhere")  # a node without a face

    def _turned_strain(self, gradient: sp.csr_matrix, nodes: np.ndarray) -> np.ndarray:
        """Return R_f U_f, shape [face_count, 3, 2], R_f the isometry nearest to F_f U_f."""
        slope = np.swapaxes((gradient @ nodes).reshape(-1, 2, 3), 1, 2)
        left, _, right = np.linalg.svd(slope @ self.strain, full_matrices=False)
        return np.asarray(left @ right @ self.strain)

    def _move_flat(self, garment: Garment, on_uv: sp.csr_matrix, wanted: np.ndarray) -> np.ndarray:
        """Return d(R U J)/dc, (d/dx, d/dy) of three coordinates of each face, shape [face_count, 2, 3, parameters]."""
        return np.einsum("fka,fdap->fdkp", wanted, _slope_rates(garment, on_uv, self.free))

    def _hold_on_target(self, garment: Garment, area: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what holds the nodes on the target: each one's block, [n, 3, 3], and right side, shape [n, 3]."""
        chosen, nodes, count = self.settings, garment.nodes, len(garment.nodes)
        mass = lump(area, garment.faces, count)
        own = TriangleSurface(nodes, garment.faces).vertex_normals
        found, seen = match_surface(self.goal, nodes, own, chosen.facing)
        for line, _ in self.borders:
            seen[line] = False
        seen &= ~self.loose
        normal = self.goal.face_normals[found.face]
        blocks = (np.where(seen, mass, 0.0) / chosen.surface**2)[:, None, None] * normal[:, :, None] * normal[:, None]
        blocks[self.hidden] = (mass[self.hidden] / chosen.surface**2)[:, None, None] * np.eye(3)
        pulled = np.einsum("vij,vj->vi", blocks, np.where(self.hidden[:, None], nodes, found.foot))
        still = mass / chosen.reach**2
        blocks += still[:, None, None] * np.eye(3)
        pulled += still[:, None] * nodes
        for line, loop in self.borders:
            near = loop.closest(nodes[line])
            tangent = loop.tangents[near.segment]
            across = np.eye(3) - (1.0 - chosen.along) * tangent[:, :, None] * tangent[:, None]
            across *= (mass[line] / chosen.border**2)[:, None, None]
            blocks[line] += across
            pulled[line] += np.einsum("vij,vj->vi", across, near.foot)
        return blocks, pulled

    def _solve_pattern(self, pattern: Pattern, matrix: np.ndarray, right: np.ndarray, area: float) -> np.ndarray:
        """Return the change of the effective control points [m] under equal seams, pulled by ratios and start."""
        damping = self.settings.keep * float(np.trace(matrix)) / len(matrix)
        matrix = matrix + self.anchor + damping * np.eye(len(matrix))
        if self.anchor.any():
            gone = np.linalg.lstsq(self.free, (pattern.points - self.start).ravel(), rcond=None)[0]
            right = right - self.anchor @ gone
        missing, rates = self.proportions.linearise(pattern)
        rates = rates @ self.free
        pull = self.settings.proportion * area
        rows = seam_rows(pattern, pattern.points) @ self.free
        return solve_sewn(matrix + pull * rates.T @ rates, right + pull * rates.T @ missing, rows, np.zeros(len(rows)))


def _anchor(garment: Garment, free: np.ndarray, loose: np.ndarray, settings: IsometrySettings) -> np.ndarray:
    """Return the matrix that holds the panels' shape where it is, by the effective control points."""
    on_uv, area = gradient_operator(garment.rest, garment.uv_faces, len(garment.uv))
    narrow = narrow_panels(garment.pattern)[garment.panel_of_face]
    stay = np.where(narrow, settings.stay_band, settings.stay)
    unseen = loose[garment.faces].any(axis=1)
    weight = area * np.where(unseen, np.maximum(stay, settings.stay_hidden), stay)
    rates = _slope_rates(garment, on_uv, free).reshape(4 * len(area), -1)
    return np.asarray(rates.T @ (np.repeat(weight, 4)[:, None] * rates))


def _slope_rates(garment: Garment, on_uv: sp.csr_matrix, free: np.ndarray) -> np.ndarray:
    """Return dJ/dc of each face, (d/dx, d/dy) of two coordinates, shape [face_count, 2, 2, effective_count]."""
    flat = (map_controls(garment).matrix @ free).reshape(len(garment.uv), -1)
    return np.asarray(on_uv @ flat).reshape(len(garment.faces), 2, 2, -1)


def _uv_of_nodes(garment: Garment) -> sp.csr_matrix:
    """Return the matrix that hands each uv vertex its node's value, shape [uv_count, node_count]."""
    count = len(garment.uv)
    ones = (np.ones(count), (np.arange(count), garment.uv_node))
    return sp.csr_matrix(ones, shape=(count, len(garment.nodes)))
