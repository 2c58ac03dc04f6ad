"""The hybrid method: pattern and place by isometry, register again, then pattern and cloth through the simulator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...body import project_outside, untangle_outside
from ...cloth import Fabric, FabricEstimate
from ...garment import resample
from ...garment.meshes import Meshes
from ...geometry import self_intersections
from ...run.hooks import SILENT, Hooks
from ..case import Case, GradedDrape
from ..drape import pin_waist
from ..grade import move_pattern
from .body_offset import estimate_body_offset, is_estimated
from .fairness import fair_garment
from .isometry import fit_isometry, steps_of
from .locks import find_held, keep_held
from .material import fit_bending, nearest_fabrics, posterior, refine_bending, state_density
from .panel_change import change_panels
from .result import Fit
from .rim_corners import prove_corners
from .scene import FitScene
from .second_registration import find_nearer, register_again
from .settings import MaterialSettings, ShapeSettings
from .shape import ShapeProblem, fit_shape
from .transfer import remesh_and_transfer


def fit_pattern(
    case: Case,
    drape: GradedDrape,
    registered: np.ndarray,
    settings: ShapeSettings = ShapeSettings(),  # noqa: B008 - frozen
    hooks: Hooks = SILENT,
) -> Fit:
    """Recover the pattern of a registered garment and drape it.

    Args:
        case: The scan with named contours, wearer, template and cloth; its settings tell the vertices of the recovered
            pattern's mesh, how to register again, and what stays as it is given: `fabric`, `panel:NAME` (and its mirror
            image).
        drape: The graded pattern's mesh at rest.
        registered: The same nodes on the target [m], shape [node_count, 3].
        settings: How to fit through the simulator.
        hooks: Progress, cancellation and checkpoints.

    Returns:
        The fit; its detail mesh is the second registration, with the pattern and the place that isometry found; where
        that ended further from the scan than the first, one that begins at the first, if it is nearer.

    Raises:
        LockUnknown: where a lock names no panel of the pattern.
    """
    from ...cloth import BendingFriction, Scene, SelfContact, Topology, equilibrium, soften

    garment, target, wearer, like, fabric = drape.garment, case.target, case.wearer, case.base, case.fabric
    material, locks, rotation = MaterialSettings(), drape.locks(case.settings), drape.drape.rotation
    held = find_held(garment.pattern, like, locks)
    isometric = fit_isometry(garment, registered, target, wearer.body, like, steps_of(case), hooks)
    changed = change_panels(isometric, case, drape, registered, hooks)
    if changed.changes:
        isometric, like, garment = changed.garment, changed.base, changed.graded
        held = find_held(garment.pattern, like, locks)
    pattern = isometric.pattern
    if held.any():
        pattern = keep_held(pattern, garment.pattern, like, held)
    refitted = remesh_and_transfer(pattern, case.settings.vertex_count, isometric, isometric.nodes, wearer.body)
    graded = resample(garment, garment.nodes, refitted)
    hooks.progress("fit", 0.2, "registering again")
    first = None if changed.changes else garment.at(registered)
    refitted = register_again(refitted, case, wearer, hooks)
    registered = refitted.nodes
    hooks.progress("fit", 0.3, "preparing the fit through the simulator")

    def problem_on(vertices: int, cloth: Fabric) -> ShapeProblem:
        """State the fit on the registered mesh, or on a coarser one."""
        mesh = refitted
        if vertices < len(registered):
            mesh = remesh_and_transfer(refitted.pattern, vertices, refitted, registered, wearer.body)
        scene = Scene(Topology.from_garment(mesh), soften(cloth), wearer.grid, pin_waist(mesh), rotation)
        return ShapeProblem.of(FitScene.of(mesh, like, scene, locked=held), settings)

    coarse = problem_on(material.vertices, fabric)
    if is_estimated(wearer.body):
        hooks.progress("fit", 0.3, "raising the body to where the cloth rests on it")
        wearer = wearer.raised(
            estimate_body_offset(replace(coarse, scene=coarse.scene.with_folds_held()), wearer, hooks)
        )
        coarse = replace(coarse, scene=coarse.scene.with_body(wearer.grid))
        registered = project_outside(registered, wearer.exposed.sparing_pinched, refitted.faces)
        registered = untangle_outside(registered, wearer.exposed.sparing_pinched, refitted.faces)
        refitted = refitted.at(registered)
        graded = project_outside(graded, wearer.exposed, refitted.faces)  # it was draped on the body as guessed
    bending: tuple[FabricEstimate, ...] = ()
    if "fabric" not in locks:
        found, estimate = fit_bending(coarse, material, hooks)
        fabric = replace(fabric, k=found.k, title=found.title, sources=found.sources)
        bending = (estimate,)
    problem = problem_on(settings.vertices, fabric)
    problem = replace(problem, scene=problem.scene.with_folds_held())
    if bending and estimate.identifiable:
        problem = problem.fitting_bending(estimate.std)
    shape = fit_shape(problem, hooks)
    problem = problem.with_fabric(shape.fabric)
    point_std, membrane, bending_std = posterior(
        problem, fabric, shape.pattern, shape.drape, problem.loss.value(shape.nodes), material
    )
    if problem.bending is not None:
        fabric, estimate = refine_bending(fabric, shape.fabric.k, bending_std, estimate, material)
        bending = (estimate,)
    estimates = (*bending, *membrane, state_density(fabric))
    unfair = move_pattern(refitted, shape.pattern)
    corners = prove_corners(unfair, registered, case.seen, like)
    recovered = fair_garment(unfair, like, held, corners)
    rest = shape.drape
    started = problem.garment is refitted and recovered is unfair and rest.converged
    if not started or len(self_intersections(rest.nodes, recovered.faces)):
        hooks.progress("fit", 0.9, "draping the recovered pattern")
        topology = Topology.from_garment(recovered)
        folds, contact = BendingFriction.at(topology, registered), SelfContact.of(topology)
        pins = pin_waist(recovered)
        scene = Scene(topology, soften(fabric), wearer.grid, pins, rotation, folds, self_contact=contact)
        starts: list[tuple[np.ndarray, np.ndarray | None]] = [] if started else [(registered, None)]
        if problem.garment is refitted:  # the fit's own drape is of this mesh
            starts.append((rest.nodes, rest.anchors))
        drapes = [equilibrium(scene, nodes, anchors=anchors, hooks=hooks) for nodes, anchors in starts]
        if len(drapes) > 1:
            drapes.sort(key=lambda drape: (not drape.converged, problem.loss.value(drape.nodes)))
        rest = drapes[0]
    simulation = project_outside(rest.nodes, wearer.exposed.sparing_pinched, recovered.faces)
    simulation = untangle_outside(simulation, wearer.exposed.sparing_pinched, recovered.faces)
    hooks.progress("fit", 0.98, "comparing both registrations")
    detail = refitted if first is None else find_nearer(first, refitted, case, wearer, hooks)
    return Fit(
        garment=recovered.at(detail.nodes),
        fabric=fabric,
        meshes=Meshes(graded, detail.nodes, simulation),
        estimates=estimates,
        nearest=nearest_fabrics(fabric),
        point_std=point_std,
        wearer=wearer,
        simulated=rest,
        warnings=() if rest.at_rest else (f"the simulation mesh is {rest.advice}",),
        base=like,
        changes=changed.changes,
        corners=corners,
    )
