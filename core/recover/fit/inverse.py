"""The inverse method: the thesis' loop on a coarse mesh, then the recovered pattern's drape at full resolution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body import project_outside, untangle_outside
from ...cloth import Drape, Fabric, FabricEstimate
from ...garment import Garment, resample
from ...run.hooks import SILENT, Hooks
from ..case import Case, GradedDrape
from ..drape import pin_waist
from .descent import Descent, DescentProblem, InverseSettings, descend
from .locks import find_held
from .losses.range import STIFFNESSES
from .material import ratio_prior, state_density
from .scene import FitScene
from .settings import MaterialSettings
from .transfer import remesh_and_transfer


@dataclass(frozen=True)
class InverseFit:
    """What the thesis' inverse fit ends at.

    Attributes:
        garment: The recovered pattern, meshed; nodes at its equilibrium, contours named.
        graded: The graded pattern's drape on that mesh [m], shape [node_count, 3].
        descent: The loop's end: its losses and what it found.
        fabric: The cloth, descended to, or the given one where it is locked.
        estimates: What is known of each parameter of the fabric: descent tells no posterior.
        simulated: The equilibrium behind the garment's nodes.
        warnings: What the user should know, one sentence each.
    """

    garment: Garment
    graded: np.ndarray
    descent: Descent
    fabric: Fabric
    estimates: tuple[FabricEstimate, ...]
    simulated: Drape
    warnings: tuple[str, ...]


def fit_inverse(
    case: Case,
    graded: GradedDrape,
    settings: InverseSettings = InverseSettings(),  # noqa: B008 - frozen
    hooks: Hooks = SILENT,
) -> InverseFit:
    """Recover a pattern as the thesis does: descend through the simulator from the graded pattern's drape.

    Args:
        case: The scan with named contours, wearer, template and the cloth to begin with; its settings tell the vertices
            of the recovered pattern's mesh, and what stays as it is given: `fabric`, `panel:NAME` (and its mirror
            image).
        graded: The graded pattern's mesh at rest.
        settings: Weights and steps.
        hooks: Progress, cancellation and checkpoints.

    Raises:
        LockUnknown: where a lock names no panel of the pattern.
    """
    from ...cloth import Scene, SelfContact, Topology, equilibrium

    garment, target, wearer, fabric = graded.garment, case.target, case.wearer, case.fabric
    locks, rotation = graded.locks(case.settings), graded.drape.rotation
    held = find_held(garment.pattern, case.base, locks)
    count = min(settings.vertices, len(garment.nodes))
    coarse = remesh_and_transfer(garment.pattern, count, garment, garment.nodes, wearer.body)
    cloth = Scene(Topology.from_garment(coarse), fabric, wearer.grid, pin_waist(coarse, target), rotation)
    problem = DescentProblem.of(FitScene.of(coarse, case.base, cloth, STIFFNESSES, held), target, settings)
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
    return InverseFit(
        garment=fine.at(untangle_outside(nodes, wearer.exposed.sparing_pinched, fine.faces)),
        graded=resample(garment, garment.nodes, fine),
        descent=descent,
        fabric=found,
        estimates=_state_fabric(found) if fit_fabric else (),
        simulated=drape,
        warnings=() if drape.at_rest else (f"the simulation mesh is {drape.advice}",),
    )


def _state_fabric(fabric: Fabric) -> tuple[FabricEstimate, ...]:
    """State the found stiffnesses with the prior's spread: a descent says where it ended, not how sure that is."""
    note = "descended to; how well it is known was not asked (the hybrid method tells)"
    spreads = {name: ratio_prior(name, MaterialSettings())[1] for name in STIFFNESSES}
    found = (FabricEstimate(n, getattr(fabric, n), spreads[n], spreads[n], False, note) for n in STIFFNESSES)
    return (*found, state_density(fabric))
