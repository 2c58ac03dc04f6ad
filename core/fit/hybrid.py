"""The hybrid method: pattern and place by isometry, register again, then pattern and cloth through the simulator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..body import project_outside
from ..deform import Deformation, DeformSettings, deform
from ..drape import WearerGeometry, pin_waist
from ..grade import move_pattern
from ..hooks import SILENT, Hooks
from ..pattern import Garment, Pattern, resample
from ..segment import Target
from ..simulate import Fabric, FabricEstimate
from .body_offset import estimate_body_offset, is_estimated
from .isometry import fit_isometry
from .locks import find_held, keep_held
from .material import fit_bending, nearest_fabrics, posterior, refine_bending, state_density
from .settings import MaterialSettings, ShapeSettings
from .shape import ShapeFit, ShapeProblem, fit_shape
from .transfer import remesh_and_transfer

if TYPE_CHECKING:
    from ..simulate import SteadyRotation


@dataclass(frozen=True)
class PatternFit:
    """Hold what the inverse fit found.

    Attributes:
        garment: The recovered pattern, meshed anew; nodes registered.
        graded: The graded pattern's drape on that mesh [m], shape [node_count, 3].
        detail: The second registration, with the pattern and the place that isometry found.
        simulation: The recovered pattern's equilibrium on the same mesh [m], shape [node_count, 3].
        shape: The fit through the simulator.
        fabric: The cloth, its bending found from the folds, or the given one where it is locked.
        estimates: What the drape tells of each parameter of the fabric.
        nearest: Fabrics of the library that bend most alike, by name.
        point_std: Posterior standard deviation of the control points [m], shape [point_count, 2].
        warnings: What the user should know, one sentence each.
    """

    garment: Garment
    graded: np.ndarray
    detail: Deformation
    simulation: np.ndarray
    shape: ShapeFit
    fabric: Fabric
    estimates: tuple[FabricEstimate, ...]
    nearest: tuple[str, ...]
    point_std: np.ndarray
    warnings: tuple[str, ...]


def fit_pattern(
    garment: Garment,
    registered: np.ndarray,
    target: Target,
    like: Pattern,
    fabric: Fabric,
    wearer: WearerGeometry,
    *,
    vertex_count: int | None = None,
    settings: ShapeSettings | None = None,
    deforming: DeformSettings | None = None,
    locks: tuple[str, ...] = (),
    rotation: SteadyRotation | None = None,
    hooks: Hooks = SILENT,
) -> PatternFit:
    """Recover the pattern of a registered garment and drape it.

    Args:
        garment: The graded pattern's mesh, nodes at its drape, contours named.
        registered: The same nodes on the target [m], shape [node_count, 3].
        target: The scan's surface with named contours.
        like: The template: tells symmetry, proportions and gathered seams.
        fabric: The cloth.
        wearer: The wearer's geometry.
        vertex_count: Vertices of the recovered pattern's mesh, or None for as many as there are.
        settings: How to fit through the simulator.
        deforming: How to register again.
        locks: What stays as it is given: `fabric`, `panel:NAME` (and its mirror image).
        rotation: The rotation in which the cloth was scanned, or None for cloth at rest.
        hooks: Progress, cancellation and checkpoints.

    Raises:
        LockUnknown: where a lock names no panel of the pattern.
    """
    from ..simulate import BendingFriction, Scene, Topology, equilibrium, soften

    settings, material = settings or ShapeSettings(), MaterialSettings()
    warnings = []
    held = find_held(garment.pattern, like, locks)
    isometric = fit_isometry(garment, registered, target, wearer.body, like, hooks=hooks)
    pattern = isometric.pattern
    if held.any():
        pattern = keep_held(pattern, garment.pattern, like, held)
    refitted = remesh_and_transfer(pattern, vertex_count or len(registered), isometric, isometric.nodes, wearer.body)
    graded = resample(garment, garment.nodes, refitted)
    hooks.progress("fit", 0.2, "registering again")
    again = (deforming or DeformSettings()).going_on()
    detail = deform(refitted, target, wearer.exposed, settings=again, hooks=hooks.quiet())
    registered = detail.nodes
    refitted = refitted.at(registered)
    hooks.progress("fit", 0.3, "preparing the fit through the simulator")

    def problem_on(vertices: int, cloth: Fabric) -> ShapeProblem:
        """State the fit on the registered mesh, or on a coarser one."""
        mesh = refitted
        if vertices < len(registered):
            mesh = remesh_and_transfer(refitted.pattern, vertices, refitted, registered, wearer.body)
        return ShapeProblem.of(mesh, like, soften(cloth), wearer.grid, pin_waist(mesh), settings, held, rotation)

    coarse = problem_on(material.vertices, fabric)
    if is_estimated(wearer.body):
        hooks.progress("fit", 0.3, "raising the body to where the cloth rests on it")
        coarse = replace(coarse, grid=estimate_body_offset(coarse.holding_folds(), hooks))
    bending: tuple[FabricEstimate, ...] = ()
    if "fabric" not in locks:
        found, estimate = fit_bending(coarse, material, hooks)
        fabric = replace(fabric, k=found.k, title=found.title, sources=found.sources)
        bending = (estimate,)
    problem = replace(problem_on(settings.vertices, fabric), grid=coarse.grid).holding_folds()
    if bending and estimate.identifiable:
        problem = problem.fitting_bending(estimate.std)
    shape = fit_shape(problem, hooks)
    problem = replace(problem, fabric=shape.fabric)
    point_std, membrane, bending_std = posterior(
        problem, fabric, shape.pattern, shape.drape, problem.loss.value(shape.nodes), material
    )
    if problem.bending is not None:
        fabric, estimate = refine_bending(fabric, shape.fabric.k, bending_std, estimate, material)
        bending = (estimate,)
    estimates = (*bending, *membrane, state_density(fabric))
    recovered = move_pattern(refitted, shape.pattern)
    drape = shape.drape
    if problem.garment is not refitted or not drape.converged:
        hooks.progress("fit", 0.9, "draping the recovered pattern")
        topology = Topology.from_garment(recovered)
        folds = BendingFriction.at(topology, registered)
        scene = Scene(topology, soften(fabric), problem.grid, pin_waist(recovered), rotation, folds)
        drape = equilibrium(scene, registered, hooks=hooks)
    if not drape.converged:
        warnings.append(f"the simulation mesh is {drape.outcome.advice}")
    simulation = project_outside(drape.nodes, wearer.exposed, recovered.faces)
    return PatternFit(
        recovered,
        graded,
        detail,
        simulation,
        shape,
        fabric,
        estimates,
        nearest_fabrics(fabric),
        point_std,
        tuple(warnings),
    )
