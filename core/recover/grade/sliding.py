"""Slide a graded pattern's seams over the target to where its flat panels are isometric to the cloth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ...body.body import Body
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.resampling import resample
from ...garment.sewing import mesh_pattern
from ...run.best import choose_best
from ...run.errors import BadInput
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.target import Target
from .grading import GradeSettings, move_pattern, step_without_folds
from .isometry import Isometry, IsometrySettings
from .seen_seams import find_traced_seams
from .strain import clamp_stretch, subgrid_stretch

MAX_TRACE_ROUND_COUNT = 3
"""Number of times that seams slide while the scan shows them elsewhere: each goes about half of the way."""


@dataclass(frozen=True)
class SlideSettings:
    """Describe the sliding of the seams.

    Attributes:
        settled: Motion of a control point in a step below which the sliding ends [m]: a tenth of the outlines' error.
        isometry: The steps. 800 vertices: 500 cut folds so short that outlines are off by 10 mm more; 1000 take half as
            long again and gain nothing. Of the strain only what the coarse mesh cuts folds short by is used: the
            template's drape has another size, and its strain changes skirts by 3 % in area. `stay` 0.02: a panel
            strained by 7 % from the graded pattern costs as much as cloth strained by 1 %; without it a waist seam
            slides without end where the surface is smooth. Bands keep their shape, for the place of their long seams is
            not visible, as does cloth that hanging arms hide: sleeves of a T-shirt lost 8 % without it, 4 % with it.
    """

    settled: float = 1e-3
    isometry: IsometrySettings = field(
        default_factory=lambda: IsometrySettings(
            vertices=800, steps=12, max_strain=0.0, start_cost=0.02, start_cost_band=1.0, start_cost_hidden=1.0
        )
    )

    def by_newton(self, curves: bool = False) -> SlideSettings:
        """Return the settings for Gauss-Newton steps, the handles of curves free or not."""
        return replace(self, isometry=self.isometry.by_newton(curves))


def slide_seams(
    garment: Garment,
    target: Target,
    body: Body,
    base: Pattern,
    *,
    settings: SlideSettings | None = None,
    hooks: Hooks = SILENT_HOOKS,
) -> Garment:
    """Slide the seams of a graded garment over the target until panels and cloth are isometric.

    Registration finds the surface to a millimetre, but not where on it a seam is, and spreads the stretch evenly. A
    developable panel can only be bent, so the seams have to be where the target's Gaussian curvature is: at the waist,
    round the arm. Each step solves for nodes and pattern at once (`Isometry`).

    **Deviation** from thesis 3.2.3, which moves the points of open contours only.

    Args:
        garment: The graded pattern's mesh, nodes registered on the target.
        target: The scan's surface with named contours.
        body: The wearer, on whom the contours are named.
        base: The template, which gives symmetry and proportions.
        settings: Steps and their end.
        hooks: Progress and cancellation.

    Returns:
        A mesh of `settings.isometry.vertices` vertices of the new pattern, its nodes on the target; of the graded
        pattern where the new one cannot be meshed (programs draw edges of 1 mm between darts, which may slide shut).
    """
    settings = settings or SlideSettings()
    chosen = settings.isometry
    found, strain = mesh_coarsely(garment, chosen)

    def tell(step: int) -> None:
        hooks.progress("grade", step / chosen.steps, "sliding the seams into place")

    slid, traced = found, find_traced_seams(found, target)
    for _ in range(MAX_TRACE_ROUND_COUNT):
        problem = Isometry.of(slid, target, body, base, strain, chosen, traced)
        slid = solve_isometry(problem, slid, settings.settled, tell)
        traced = find_traced_seams(slid, target)
        if all(np.abs(seam.distance(slid.nodes)).mean() < chosen.seam_scale for seam in traced):
            break
    tried = {"slid": slid, "as graded": found}
    return choose_best("seams", tried, lambda one: float(one is slid and not can_be_meshed(one)), hooks)


def mesh_coarsely(garment: Garment, settings: IsometrySettings) -> tuple[Garment, np.ndarray]:
    """Return a coarse mesh of a garment on the target, and the estimated strain of its faces' cloth.

    Args:
        garment: The graded pattern's mesh, nodes registered on the target.
        settings: Vertices and the bound on strain.

    Returns:
        The mesh, its nodes on the target, and U of each face, shape [face_count, 2, 2].
    """
    coarse = mesh_pattern(garment.pattern, min(settings.vertices, len(garment.nodes)))
    found = coarse.at(resample(garment, garment.nodes, coarse))
    strain = clamp_stretch(found, found, settings.max_strain) @ subgrid_stretch(found, garment, garment.nodes)
    return found, 0.5 * (strain + np.swapaxes(strain, 1, 2))


def can_be_meshed(garment: Garment) -> bool:
    """Return whether a pattern can be triangulated as finely as its garment."""
    try:
        mesh_pattern(garment.pattern, len(garment.nodes))
    except BadInput:
        return False
    return True


def solve_isometry(problem: Isometry, start: Garment, settled: float, on_step: Callable[[int], None]) -> Garment:
    """Repeat the step of a problem until the pattern rests, or the number of steps is reached.

    Steps with fixed rotations use momentum (Nesterov's, restarted where it opposes the last step: O'Donoghue and Candes
    2015); the damping of Gauss-Newton steps falls.

    Args:
        problem: The problem to solve.
        start: The garment to start from.
        settled: Largest motion of a control point in one step [m] below which it ends.
        on_step: Called with the number of each step before it is made.
    """
    chosen = problem.settings
    found = tried = start
    turn, reach = 0, chosen.reach_first if chosen.newton else chosen.reach
    for step in range(chosen.steps):
        on_step(step)
        before, found = found, problem.step(tried, reach)
        point_step = found.pattern.points - before.pattern.points
        if float(np.linalg.norm(point_step, axis=1).max()) < settled:
            break
        if chosen.newton:
            tried, reach = found, min(chosen.growth * reach, chosen.reach)
            continue
        node_step = found.nodes - before.nodes
        turn = 0 if step and float(np.sum((tried.nodes - found.nodes) * node_step)) > 0.0 else turn + 1
        share = turn / (turn + 3.0)
        further = step_without_folds(found.pattern, found.pattern.points + share * point_step, GradeSettings())[0]
        tried = move_pattern(found, further).at(found.nodes + share * node_step)
    return found
