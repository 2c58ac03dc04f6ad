"""Run the hybrid method: pattern by isometry, second registration, then pattern and cloth through the simulator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...body.projection import project_outside
from ...body.untangling import untangle_outside
from ...cloth.fabric import FabricEstimate
from ...cloth.statics import Drape
from ...garment.garment import Garment
from ...garment.meshes import Meshes
from ...garment.resampling import resample
from ...geometry.intersections import self_intersections
from ...run.hooks import SILENT_HOOKS, Hooks
from ..case import Case
from ..drape.waist_placement import pin_waist
from ..grade.grading import move_pattern
from ..state import RecoveryState, made
from .body_offset import estimate_body_offset, is_body_estimated
from .fairness import fair_garment
from .isometry import choose_isometry_settings, fit_isometry
from .locks import find_locked_coordinates, fit_reference, locks_of, restore_locked
from .material import fit_bending, nearest_fabrics, posterior, refine_bending, report_density
from .panel_change import change_panels
from .rim_corners import prove_corners
from .scene import FitScene
from .second_registration import choose_nearer_registration, register_again
from .settings import MaterialSettings, ShapeSettings
from .shape import ShapeFit, ShapeProblem, fit_shape
from .transfer import remesh_and_transfer


def fit_pattern(
    case: Case,
    state: RecoveryState,
    settings: ShapeSettings = ShapeSettings(),  # noqa: B008 - frozen
    hooks: Hooks = SILENT_HOOKS,
) -> RecoveryState:
    """Recover the pattern of a registered garment and drape it.

    Args:
        case: The scan; its settings give the vertices of the recovered pattern's mesh, the preset of the second
            registration and the locks: `fabric`, `panel:NAME` (and its mirror image).
        state: The graded pattern's mesh at its drape, and its nodes on the target.
        settings: Settings of the fit through the simulator.
        hooks: Progress, cancellation and checkpoints.

    Returns:
        The recovered garment. Its detail mesh is the second registration, from the result of isometry; where that is
        further from the scan than the first, one from the first, if that is nearer.

    Raises:
        LockUnknown: where a lock names no panel of the pattern.
    """
    start, locks, material = state, locks_of(case, state), MaterialSettings()
    reference = fit_reference(case, state)
    state = _fit_panels(case, replace(state, base=reference), hooks)
    is_same_cut = state.base is reference
    locked = find_locked_coordinates(made(state.graded).pattern, state.base, locks)
    state = _register_fitted(case, state, locked, hooks)
    coarse = _build_problem(state, locked, material.vertices, settings)
    if is_body_estimated(state.body):
        state, coarse = _raise_body(state, coarse, hooks)
    bending: tuple[FabricEstimate, ...] = ()
    if "fabric" not in locks:
        found, estimate = fit_bending(coarse, material, hooks)
        bending = (estimate,)
        state = replace(state, fabric=replace(state.fabric, k=found.k, title=found.title, sources=found.sources))
    problem = _build_problem(state, locked, settings.vertices, settings)
    problem = replace(problem, scene=problem.scene.with_fixed_folds())
    if bending and estimate.identifiable:
        problem = problem.fitting_bending(estimate.std)
    shape, fabric = fit_shape(problem, hooks), state.fabric
    problem, loss = problem.with_fabric(shape.fabric), problem.loss.value(shape.nodes)
    point_std, membrane, bending_std = posterior(problem, fabric, shape.pattern, shape.drape, loss, material)
    if problem.bending is not None:
        fabric, estimate = refine_bending(fabric, shape.fabric.k, bending_std, estimate, material)
        bending = (estimate,)
    state = replace(state, fabric=fabric, point_std=point_std, nearest=nearest_fabrics(fabric))
    state, second = replace(state, estimates=(*bending, *membrane, report_density(fabric))), made(state.garment)
    state = _simulate(case, state, problem, shape, locked, hooks)
    if not is_same_cut:
        return state
    hooks.progress("fit", 0.98, "comparing both registrations")
    first, meshes = made(start.graded).at(made(start.meshes).detail), made(state.meshes)
    detail = choose_nearer_registration(first, second, case, state, hooks).nodes
    garment = made(state.garment).at(detail)
    return replace(state, base=start.base, garment=garment, meshes=replace(meshes, detail=detail))


def _fit_panels(case: Case, state: RecoveryState, hooks: Hooks) -> RecoveryState:
    """Fit the flat panels to the registered cloth by isometry; darts may be added or closed."""
    graded, registered = made(state.graded), made(state.meshes).detail
    fitted = fit_isometry(
        graded, registered, state.target, state.body, state.base, choose_isometry_settings(case), hooks
    )
    return change_panels(case, replace(state, garment=fitted), hooks)


def _register_fitted(case: Case, state: RecoveryState, locked: np.ndarray, hooks: Hooks) -> RecoveryState:
    """Mesh the fitted pattern finely and register it, from the nodes of the isometry fit."""
    graded, fitted = made(state.graded), made(state.garment)
    pattern = fitted.pattern
    if locked.any():
        pattern = restore_locked(pattern, graded.pattern, state.base, locked)
    garment = remesh_and_transfer(pattern, case.settings.vertex_count, fitted, fitted.nodes, state.body)
    hooks.progress("fit", 0.2, "registering again")
    garment, draped = register_again(garment, case, state, hooks), resample(graded, graded.nodes, garment)
    hooks.progress("fit", 0.3, "preparing the fit through the simulator")
    return replace(state, garment=garment, meshes=Meshes(draped, garment.nodes))


def _build_problem(state: RecoveryState, locked: np.ndarray, vertices: int, settings: ShapeSettings) -> ShapeProblem:
    """Build the fit of pattern and cloth on the registered mesh, or on a coarser one."""
    from ...cloth.locking import reduce_membrane_stiffness
    from ...cloth.scene import Scene
    from ...cloth.topology import Topology

    mesh = made(state.garment)
    if vertices < len(mesh.nodes):
        mesh = remesh_and_transfer(mesh.pattern, vertices, mesh, mesh.nodes, state.body)
    cloth, rotation = reduce_membrane_stiffness(state.fabric), made(state.drape).rotation
    scene = Scene(Topology.from_garment(mesh), cloth, state.wearer.grid, pin_waist(mesh), rotation)
    return ShapeProblem.of(FitScene.of(mesh, state.base, scene, locked=locked), settings)


def _raise_body(state: RecoveryState, problem: ShapeProblem, hooks: Hooks) -> tuple[RecoveryState, ShapeProblem]:
    """Raise a body that was estimated below the cloth to where the cloth rests on it."""
    hooks.progress("fit", 0.3, "raising the body to where the cloth rests on it")
    offset = estimate_body_offset(replace(problem, scene=problem.scene.with_fixed_folds()), state.wearer, hooks)
    wearer, garment = state.wearer.raised(offset), made(state.garment)
    skin, faces = wearer.exposed.sparing_pinched, garment.faces
    registered = untangle_outside(project_outside(garment.nodes, skin, faces), skin, faces)
    graded = project_outside(made(state.meshes).graded, wearer.exposed, faces)  # draped on the body before raising
    state = replace(state, wearer=wearer, garment=garment.at(registered), meshes=Meshes(graded, registered))
    return state, replace(problem, scene=problem.scene.with_body(wearer.grid))


def _simulate(
    case: Case, state: RecoveryState, problem: ShapeProblem, shape: ShapeFit, locked: np.ndarray, hooks: Hooks
) -> RecoveryState:
    """Make the fitted pattern's curves fair and bring it to rest: the simulation mesh."""
    registered, meshes = made(state.garment), made(state.meshes)
    fitted = move_pattern(registered, shape.pattern)
    corners = prove_corners(fitted, registered.nodes, case.scan_target, state.base)
    recovered = fair_garment(fitted, state.base, locked, corners)
    rest, is_same_mesh = shape.drape, problem.garment is registered
    is_settled = is_same_mesh and recovered is fitted and rest.converged
    if not is_settled or len(self_intersections(rest.nodes, recovered.faces)):
        hooks.progress("fit", 0.9, "draping the recovered pattern")
        start = (rest.nodes, rest.anchors) if is_same_mesh else (registered.nodes, None)
        rest = _find_equilibrium(state, recovered, start, hooks)
    skin = state.wearer.exposed.sparing_pinched
    nodes = project_outside(rest.nodes, skin, recovered.faces)
    nodes = untangle_outside(nodes, skin, recovered.faces)
    meshes = Meshes(meshes.graded, registered.nodes, nodes)
    state = replace(state, garment=recovered.at(registered.nodes), meshes=meshes, simulated=rest, corners=corners)
    return state.with_notes(*(() if rest.at_rest else (f"the simulation mesh is {rest.advice}",)))


def _find_equilibrium(
    state: RecoveryState, recovered: Garment, start: tuple[np.ndarray, np.ndarray | None], hooks: Hooks
) -> Drape:
    """Return the equilibrium, with self-contact, of the recovered pattern from nodes and friction's anchors [m]."""
    from ...cloth.bending_friction import BendingFriction
    from ...cloth.collision.self_contact import SelfContact
    from ...cloth.locking import reduce_membrane_stiffness
    from ...cloth.scene import Scene
    from ...cloth.statics import equilibrium
    from ...cloth.topology import Topology

    topology, rotation = Topology.from_garment(recovered), made(state.drape).rotation
    folds, contact = BendingFriction.at(topology, made(state.garment).nodes), SelfContact.of(topology)
    cloth, grid, pins = reduce_membrane_stiffness(state.fabric), state.wearer.grid, pin_waist(recovered)
    scene = Scene(topology, cloth, grid, pins, rotation, folds, self_contact=contact)
    return equilibrium(scene, start[0], anchors=start[1], hooks=hooks)
