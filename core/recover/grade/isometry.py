"""Make panels and the cloth on a surface isometric: one linear system for nodes and control points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from ...body.body import Body
from ...garment.control import update_flat_mesh
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.seams import equalise_seams
from ...geometry.curves import Curve
from ...geometry.geometry import gradient_operator, lump, shape_gradients
from ...geometry.surface import TriangleSurface
from ...scan.contours.contours import name_contours
from ...scan.contours.target import Target
from .armpits import Armpits
from .flattening import narrow_panels, solve_with_seams
from .grading import is_sound, move_pattern
from .pattern_parameters import PatternParameters
from .proportion import Proportions, find_proportions
from .registration import match_surface
from .seen_seams import SeenSeam, find_seen_seams, find_traced_seams

if TYPE_CHECKING:
    from ...cloth.block_pattern import BlockPattern
    from ...geometry.linear import Solver


@dataclass(frozen=True)
class IsometrySettings:
    """Describe the joint fit of pattern and nodes.

    Attributes:
        vertices: Number of vertices of its mesh; 1000 have edges of 3 cm, and a step takes 0.1 s.
        steps: Largest number of steps; most garments converge after 5 to 10.
        surface: Distance of a node from the target's tangent plane [m] that costs as much per area as a strain of 1.
            With 4 mm nodes stay on the surface, and a fold may be cut short.
        border: The same for a node on an open contour, across the contour [m].
        along: Share of that cost for sliding along the contour, which is not visible.
        newton: True for Gauss-Newton steps on Green's strain, False for steps with fixed rotations (`Isometry`).
        reach, reach_first: Damping: the motion in one step [m] that costs as much as a strain of 1; only needed where
            nothing else holds a node. Gauss-Newton steps begin with `reach_first`, which moves a seam by a few
            centimetres at once; from step to step it grows up to `reach`, which fixes only
            nodes that nothing else fixes.
        growth: Factor by which the reach grows from step to step.
        trials: Largest number of times that a step is tried, half as long each time.
        farthest: Largest motion of a node in one Gauss-Newton step [m], two edges: beyond, its closest point changes.
        proportion: Cost of one standard deviation of a rule of `Proportions`, by the garment's area [1]: as much as a
            strain of 3 % everywhere, which unlike cloth and folds leave; in Gauss-Newton steps 1.7 %. There panels of
            25 drapes were 0.15 % further off with 3 %, and their outlines 0.3 mm.
        max_strain: Bound on the strain of a drape's cloth [1]: above a tenth the triangles are bad. A garment that
            hangs from its neck, or is tight, is strained by more than the 3 % of cloth that hangs free: clipped to 3 %,
            panels of ten garments are 2.7 % off in area, to 10 % 2.4 %, to 30 % 2.5 %.
        facing: Cosine of matched normals, as in the coarse registration.
        curves: True where the handles of curves move, too.
        damping: Damping of the parameters, as a share of the mean diagonal of their matrix.
        start_cost: Weight of a panel's strain from the start of the fit, relative to the cloth's; 0 for free panels.
        start_cost_band: Weight of the same relative to the cloth's for panels narrower than 12 cm.
        start_cost_hidden: Weight of it relative to the cloth's at nodes that a hanging arm hides where a sleeve begins,
            or beside them; if not 0 these follow their panels, for a drape sags in the armpit, and lengths from there
            are wrong.
        seam_scale: Distance of a seam's node from its seen place that costs as a strain of 1 [m].
        by_curvature: Whether seams are also seen by curvature (`find_seen_seams`), not by colours alone.
    """

    vertices: int = 1000
    steps: int = 24
    surface: float = 0.004
    border: float = 0.002
    along: float = 0.05
    newton: bool = False
    reach: float = 3.0
    reach_first: float = 1.0
    growth: float = 2.0
    trials: int = 5
    farthest: float = 0.06
    proportion: float = 0.001
    max_strain: float = 0.10
    facing: float = 0.3
    curves: bool = False
    damping: float = 1e-4
    start_cost: float = 0.0
    start_cost_band: float = 0.0
    start_cost_hidden: float = 0.0
    seam_scale: float = 0.005
    by_curvature: bool = False

    def by_newton(self, curves: bool = False) -> IsometrySettings:
        """Return the settings for Gauss-Newton steps, the handles of curves free or not."""
        return replace(self, newton=True, curves=curves, reach=10.0, proportion=0.0003, by_curvature=True)


@dataclass(frozen=True)
class _Model:
    """Describe a garment's strain and place to first order.

    Attributes:
        strain: E as vectors of the same length, shape [face_count, k].
        by_nodes: Its rates by a face's corners, shape [face_count, k, corner, coordinate].
        by_flat: Its negative rates by the parameters, shape [face_count, k, parameter_count].
        area: Flat area of each face [m2].
        mass: Area of each node [m2].
        ties: Stiffness of each node's tie to the target, shape [node_count, 3, 3].
        pulled: Load of each tie, shape [node_count, 3].
    """

    strain: np.ndarray
    by_nodes: np.ndarray
    by_flat: np.ndarray
    area: np.ndarray
    mass: np.ndarray
    ties: np.ndarray
    pulled: np.ndarray


@dataclass(frozen=True)
class Isometry:
    """Describe the problem that stays the same from step to step.

    Minimises over the nodes x and the parameters c of the pattern (`PatternParameters`) at once
        sum_f A_f |E_f|^2 + sum_v a_v (n_v . (x_v - q_v))^2 / l^2 + contours + seams + w A sum_k r_k^2
        + sum_f b_f A_f |J_f G_f - I|^2
    by repeated linear least squares, from which the nodes are eliminated. With fixed rotations R_f a step has E = F - R
    U J (a local-global scheme); a seam then moves slowly, which momentum accelerates (`solve_isometry`). By
    Gauss-Newton steps on Green's strain, E = (F^T F - J^T U^2 J) / 2, which is independent of a face's rotation, it
    slides over a bend at once. Seams stay equal to first order and are equalised after each step.

    Notation: E_f deviation of the cloth from the wanted strain; F_f the map from face f's present flat shape to 3D, J_f
    the map to its new flat shape, linear in c; U_f the strain that the cloth has on the target, R_f the isometry
    nearest to F_f U_f; q_v, n_v closest point and normal on the target, l `surface`; r_k deviations from the rules of
    `Proportions` and `PatternParameters`, w `proportion`, A the garment's area; J_f G_f the map from the flat shape at
    the start, b_f `stay`, `stay_band` or `stay_hidden`.

    Attributes:
        goal: The target.
        hidden: Nodes between the trunk and a hanging arm, which stay where they are, shape [node_count].
        loose: Nodes that `stay_hidden` leaves free, shape [node_count]; none of them is `hidden`.
        borders: Nodes of each open contour, and the target's contour or, if not trusted, their own place [m].
        seams: Nodes of seams whose place is visible, and their planes.
        strain: U, shape [face_count, 2, 2].
        free: The free parameters of the pattern.
        proportions: Rules to keep.
        start: The pattern at the start.
        anchor: Matrix of the last sum, shape [parameter_count, parameter_count].
        coupled: Which nodes share a face.
        slots: Places of each face's blocks, shape [face_count, 6].
        solver: Solver analysed for `coupled`.
        settings: Weights and steps.
    """

    goal: TriangleSurface
    hidden: np.ndarray
    loose: np.ndarray
    borders: tuple[tuple[np.ndarray, Curve], ...]
    seams: tuple[SeenSeam, ...]
    strain: np.ndarray
    free: PatternParameters
    proportions: Proportions
    start: Pattern
    anchor: np.ndarray
    coupled: BlockPattern
    slots: np.ndarray
    solver: Solver
    settings: IsometrySettings

    @classmethod
    def of(
        cls,
        garment: Garment,
        target: Target,
        body: Body,
        base: Pattern,
        strain: np.ndarray,
        settings: IsometrySettings,
        traced: tuple[SeenSeam, ...] | None = None,
    ) -> Isometry:
        """Prepare the fit of a garment whose nodes are on the target.

        Args:
            garment: The mesh to start from; its contours are named where they are not yet.
            target: The scan's surface with named contours.
            body: The wearer, on whom the contours are named.
            base: The template, which gives symmetry and proportions.
            strain: U of each face, shape [face_count, 2, 2].
            settings: Weights and steps.
            traced: Seams that the scan's cloth shows, where they were found already.
        """
        from ...cloth.block_pattern import BlockPattern
        from ...cloth.solver import make_solver

        borders = []
        for contour in garment.contours or name_contours(garment.nodes, garment.faces, body)[0]:
            other = target.contour(contour.name)
            # Without a trusted contour the border stays where registration left it: free panels would shrink.
            curve = contour.curve(garment.nodes)
            if other is not None and other.trusted:
                curve = other.curve(target.vertices)
            borders.append((contour.vertices, curve))
        armpits = Armpits.of(garment, body)
        hidden, loose = armpits.hidden, np.zeros_like(armpits.hidden)
        if settings.start_cost_hidden > 0.0 and armpits.fixed.any():
            loose[garment.faces[hidden[garment.faces].any(axis=1)]] = True  # next to them is what scans have instead
        on_border = [node for line, _ in borders for node in line]
        hidden[on_border] = loose[on_border] = False
        hidden &= ~loose
        free = PatternParameters.of(base, settings.curves)
        curved = find_seen_seams(garment, target, body) if settings.by_curvature else ()
        coupled, (slots,) = BlockPattern.of(len(garment.nodes), garment.faces)
        return cls(
            goal=TriangleSurface(target.vertices, target.faces),
            hidden=hidden,
            loose=loose,
            borders=tuple(borders),
            seams=(*curved, *(find_traced_seams(garment, target) if traced is None else traced)),
            strain=strain,
            free=free,
            proportions=find_proportions(base),
            start=garment.pattern,
            anchor=_anchor(garment, free, loose, settings),
            coupled=coupled,
            slots=slots,
            solver=make_solver(coupled),
            settings=settings,
        )

    def step(self, garment: Garment, reach: float) -> Garment:
        """Return the garment after one step, halved until no panel folds over; unchanged if none is found."""
        change, moved = self._solve(self._linearise(garment), garment, reach)
        share, follow = 1.0, update_flat_mesh if self.free.has_curves else move_pattern
        if self.settings.newton:
            share = min(1.0, self.settings.farthest / max(float(np.linalg.norm(moved, axis=1).max()), 1e-9))
        for _ in range(self.settings.trials):
            pattern = equalise_seams(self.free.move(garment.pattern, share * change), base=garment.pattern)
            if is_sound(pattern, garment.pattern):
                return follow(garment, pattern).at(garment.nodes + share * moved)
            share /= 2.0
        return garment

    def _linearise(self, garment: Garment) -> _Model:
        """Return strain and place of a garment with their rates."""
        gradients = shape_gradients(garment.rest)
        slope = np.einsum("fkc,fkd->fcd", garment.nodes[garment.faces], gradients)
        on_uv, area = gradient_operator(garment.rest, garment.uv_faces, len(garment.uv))
        rates = _slope_rates(garment, on_uv, self.free)
        if self.settings.newton:
            metric = self.strain @ self.strain
            strain = _as_vector(0.5 * (np.swapaxes(slope, 1, 2) @ slope - metric))
            # the rate of F^T F / 2 by corner k's coordinate c is sym(g_k x (row c of F))
            by_nodes = _as_vector(np.einsum("fki,fcj->fijkc", gradients, slope))
            by_flat = _as_vector(np.einsum("fia,fjap->fijp", metric, rates))
        else:
            metric = self._turn_strain(slope)
            count = len(slope)
            strain = (slope - metric).reshape(count, 6)
            by_nodes = np.einsum("fkd,ce->fcdke", gradients, np.eye(3)).reshape(count, 6, 3, 3)
            by_flat = np.einsum("fca,fdap->fcdp", metric, rates).reshape(count, 6, -1)
        return _Model(strain, by_nodes, by_flat, area, *self._tie(garment, area))

    def _turn_strain(self, slope: np.ndarray) -> np.ndarray:
        """Return R U, shape [face_count, 3, 2], R the isometry nearest to F U."""
        left, _, right = np.linalg.svd(slope @ self.strain, full_matrices=False)
        return np.asarray(left @ right @ self.strain)

    def _solve(self, model: _Model, garment: Garment, reach: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the change of the parameters and of the nodes [m], shape [node_count, 3]."""
        count, parameters = len(garment.nodes), model.by_flat.shape[2]
        weighted = model.area[:, None, None, None] * model.by_nodes
        blocks = np.zeros((len(self.coupled.rows), 3, 3))
        for slots, (i, j) in zip(self.slots.T, zip(*np.triu_indices(3), strict=True), strict=True):
            block = np.einsum("fsc,fsd->fcd", weighted[:, :, i], model.by_nodes[:, :, j])
            turned = slots < 0
            np.add.at(blocks, slots[~turned], block[~turned])
            np.add.at(blocks, ~slots[turned], np.swapaxes(block[turned], 1, 2))
        blocks[self.coupled.diagonal] += model.ties + (model.mass / reach**2)[:, None, None] * np.eye(3)
        if not self.solver.factor(self.coupled.assemble(blocks)):
            raise np.linalg.LinAlgError("the cloth on the target is not held everywhere")  # a node without a face

        def gather(rates: np.ndarray) -> np.ndarray:
            """Return faces' strain rates [face_count, k, n] summed over their nodes, shape [3 node_count, n]."""
            found = np.zeros((count, 3, rates.shape[2]))
            np.add.at(found, garment.faces, np.einsum("fskc,fsp->fkcp", weighted, rates))
            return found.reshape(3 * count, -1)

        coupling = gather(model.by_flat)
        load = (model.pulled - gather(model.strain[:, :, None]).reshape(-1, 3)).ravel()
        alone, follow = self.solver.solve(load), self.solver.solve(coupling)
        flat = model.by_flat.reshape(-1, parameters)
        by_area = np.repeat(model.area, model.strain.shape[1])
        normal_matrix = flat.T @ (by_area[:, None] * flat)
        matrix = normal_matrix - coupling.T @ follow
        if self.settings.newton:
            matrix += np.diag(np.diag(normal_matrix)) / reach**2
        right = flat.T @ (by_area * model.strain.ravel()) + coupling.T @ alone
        change = self._solve_pattern(garment.pattern, matrix, right, float(model.area.sum()))
        return change, (alone + follow @ change).reshape(-1, 3)

    def _tie(self, garment: Garment, area: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return each node's area, stiffness, shape [n, 3, 3], and load, shape [n, 3], of its tie to the target."""
        chosen, nodes, count = self.settings, garment.nodes, len(garment.nodes)
        mass = lump(area, garment.faces, count)
        normals = TriangleSurface(nodes, garment.faces).vertex_normals
        found, seen = match_surface(self.goal, nodes, normals, chosen.facing)
        for rim, _ in self.borders:
            seen[rim] = False
        seen &= ~self.loose
        normal = self.goal.face_normals[found.face]
        ties = (np.where(seen, mass, 0.0) / chosen.surface**2)[:, None, None] * normal[:, :, None] * normal[:, None]
        ties[self.hidden] = (mass[self.hidden] / chosen.surface**2)[:, None, None] * np.eye(3)
        offset = np.where(self.hidden[:, None], 0.0, found.foot - nodes)
        for rim, loop in self.borders:
            closest = loop.closest(nodes[rim])
            tangent = loop.tangents[closest.segment]
            across = np.eye(3) - (1.0 - chosen.along) * tangent[:, :, None] * tangent[:, None]
            ties[rim] = (mass[rim] / chosen.border**2)[:, None, None] * across
            offset[rim] = closest.foot - nodes[rim]
        pulled = np.einsum("vij,vj->vi", ties, offset)
        for seam in self.seams:
            stiff = mass[seam.nodes] / chosen.seam_scale**2
            ties[seam.nodes] += stiff[:, None, None] * seam.normals[:, :, None] * seam.normals[:, None]
            pulled[seam.nodes] -= (stiff * seam.distance(nodes))[:, None] * seam.normals
        return mass, ties, pulled

    def _solve_pattern(self, pattern: Pattern, matrix: np.ndarray, right: np.ndarray, area: float) -> np.ndarray:
        """Return the change of the parameters under equal seams, with the rules and the start."""
        damping = self.settings.damping * float(np.trace(matrix)) / len(matrix)
        matrix = matrix + self.anchor + damping * np.eye(len(matrix))
        if self.anchor.any():
            right = right - self.anchor @ self.free.difference(pattern, self.start)
        pull = self.settings.proportion * area
        for missing, rates in (self._measure_proportions(pattern), self.free.shape_rules(pattern)):
            matrix = matrix + pull * rates.T @ rates
            right = right + pull * rates.T @ missing
        rows = self.free.seam_rows(pattern)
        return solve_with_seams(matrix, right, rows, np.zeros(len(rows)))

    def _measure_proportions(self, pattern: Pattern) -> tuple[np.ndarray, np.ndarray]:
        """Return the deviations from the rules of proportion, and their rates by the parameters."""
        missing, by_points = self.proportions.linearise(pattern)
        if not self.free.has_curves:
            return missing, by_points @ self.free.points
        return missing, self.free.combine(by_points, self.proportions.curve_rates(pattern))


def _anchor(garment: Garment, free: PatternParameters, loose: np.ndarray, settings: IsometrySettings) -> np.ndarray:
    """Return the matrix that keeps the panels' shape, by the parameters."""
    on_uv, area = gradient_operator(garment.rest, garment.uv_faces, len(garment.uv))
    narrow = narrow_panels(garment.pattern)[garment.panel_of_face]
    stay = np.where(narrow, settings.start_cost_band, settings.start_cost)
    unseen = loose[garment.faces].any(axis=1)
    weight = area * np.where(unseen, np.maximum(stay, settings.start_cost_hidden), stay)
    rates = _slope_rates(garment, on_uv, free).reshape(4 * len(area), -1)
    return np.asarray(rates.T @ (np.repeat(weight, 4)[:, None] * rates))


def _slope_rates(garment: Garment, on_uv: sp.csr_matrix, free: PatternParameters) -> np.ndarray:
    """Return dJ/dc of each face, (d/dx, d/dy) of two coordinates, shape [face_count, 2, 2, parameter_count]."""
    flat = free.rates(garment).reshape(len(garment.uv), -1)
    return np.asarray(on_uv @ flat).reshape(len(garment.faces), 2, 2, -1)


def _as_vector(matrix: np.ndarray) -> np.ndarray:
    """Return the symmetric parts of 2x2 matrices, shape [n, 2, 2, ...], as vectors of equal norm, shape [n, 3, ...]."""
    shear = (matrix[:, 0, 1] + matrix[:, 1, 0]) / np.sqrt(2.0)
    return np.stack([matrix[:, 0, 0], matrix[:, 1, 1], shear], axis=1)
