"""Run the inverse method: the thesis' loop on a coarse mesh, then the recovered pattern's drape at full resolution."""

from __future__ import annotations

from dataclasses import replace

from ...body.projection import project_outside
from ...body.untangling import untangle_outside
from ...cloth.fabric import Fabric, FabricEstimate
from ...run.hooks import SILENT_HOOKS, Hooks
from ..case import Case
from ..drape.waist_placement import pin_waist
from ..state import RecoveryState, made
from .descent import DescentProblem, InverseSettings, descend
from .locks import find_locked_coordinates, fit_reference, locks_of
from .losses.range import STIFFNESSES
from .material import nearest_fabrics, ratio_prior, report_density
from .scene import FitScene
from .settings import MaterialSettings
from .transfer import remesh_and_transfer


def fit_inverse(
    case: Case,
    state: RecoveryState,
    settings: InverseSettings = InverseSettings(),  # noqa: B008 - frozen
    hooks: Hooks = SILENT_HOOKS,
) -> RecoveryState:
    """Recover a pattern as in the thesis, by a descent through the simulator from the graded pattern's drape.

    Args:
        case: Its settings give the mesh's vertices and the locks (`fabric`, `panel:NAME` and its mirror image).
        state: Target, wearer, the cloth to begin with, and the graded pattern's mesh at rest.
        settings: Weights and steps.
        hooks: Progress, cancellation and checkpoints.

    Returns:
        The state with the pattern's mesh at its equilibrium, and the fabric of the descent.

    Raises:
        LockUnknown: where a lock names no panel of the pattern.
    """
    from ...cloth.collision.self_contact import SelfContact
    from ...cloth.scene import Scene
    from ...cloth.statics import equilibrium
    from ...cloth.topology import Topology

    garment, target, wearer, fabric = made(state.graded), state.target, state.wearer, state.fabric
    locks, rotation, reference = locks_of(case, state), made(state.drape).rotation, fit_reference(case, state)
    locked = find_locked_coordinates(garment.pattern, reference, locks)
    count = min(settings.vertices, len(garment.nodes))
    coarse = remesh_and_transfer(garment.pattern, count, garment, garment.nodes, wearer.body)
    cloth = Scene(Topology.from_garment(coarse), fabric, wearer.grid, pin_waist(coarse, target), rotation)
    problem = DescentProblem.of(FitScene.of(coarse, reference, cloth, STIFFNESSES, locked), target, settings)
    fit_fabric = "fabric" not in locks and settings.fabric_iterations > 0
    descent = descend(problem, hooks, fit_fabric)
    hooks.progress("fit", 0.9, "draping the recovered pattern")
    pattern, count = problem.pattern_of(descent.best), case.settings.vertex_count
    fine = remesh_and_transfer(pattern, count, coarse, descent.best_nodes, wearer.body)
    found = problem.fabric_of(descent.best) if fit_fabric else fabric
    topology = Topology.from_garment(fine)
    contact, pins = SelfContact.of(topology), pin_waist(fine, target)
    scene = Scene(topology, found, wearer.grid, pins, rotation, self_contact=contact)
    drape = equilibrium(scene, fine.nodes, hooks=hooks)
    nodes = project_outside(drape.nodes, wearer.exposed.sparing_pinched, fine.faces)
    found_state = replace(
        state,
        garment=fine.at(untangle_outside(nodes, wearer.exposed.sparing_pinched, fine.faces)),
        laid=None,  # it belongs to another mesh
        fabric=found,
        simulated=drape,
        estimates=_report_fabric(found) if fit_fabric else (),
        nearest=nearest_fabrics(found),
    )
    return found_state.with_notes(*(() if drape.at_rest else (f"the simulation mesh is {drape.advice}",)))


def _report_fabric(fabric: Fabric) -> tuple[FabricEstimate, ...]:
    """Return the found stiffnesses with the prior's spread, for a descent gives no standard deviations."""
    note = "end of the descent, without a standard deviation (the hybrid method estimates it)"
    spreads = {name: ratio_prior(name, MaterialSettings())[1] for name in STIFFNESSES}
    found = (FabricEstimate(n, getattr(fabric, n), spreads[n], spreads[n], False, note) for n in STIFFNESSES)
    return (*found, report_density(fabric))
