"""The inverse method: the thesis' loop on a coarse mesh, then the recovered pattern's drape at full resolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..body import project_outside
from ..drape import WearerGeometry, pin_waist
from ..hooks import SILENT, Hooks
from ..pattern import Garment, Pattern, resample
from ..segment import Target
from ..simulate import Fabric, FabricEstimate
from .descent import Descent, DescentProblem, InverseSettings, descend
from .locks import find_held
from .losses.range import STIFFNESSES
from .material import nearest_fabrics, ratio_prior, state_density
from .settings import MaterialSettings
from .transfer import remesh_and_transfer

if TYPE_CHECKING:
    from ..simulate import SteadyRotation


@dataclass(frozen=True)
class InverseFit:
    """Hold what the thesis' inverse fit found.

    Attributes:
        garment: The recovered pattern, meshed; nodes at its drape, contours named.
        graded: The graded pattern's drape on that mesh [m], shape [node_count, 3].
        simulation: The recovered pattern's equilibrium [m], shape [node_count, 3].
        descent: The loop's end: its losses and what it found.
        fabric: The cloth, descended to, or the given one where it is locked.
        estimates: What is known of each parameter of the fabric: descent tells no posterior.
        nearest: Fabrics of the library that bend most alike, by name.
        warnings: What the user should know, one sentence each.
    """

    garment: Garment
    graded: np.ndarray
    simulation: np.ndarray
    descent: Descent
    fabric: Fabric
    estimates: tuple[FabricEstimate, ...]
    nearest: tuple[str, ...]
    warnings: tuple[str, ...]


def fit_inverse(
    garment: Garment,
    target: Target,
    like: Pattern,
    fabric: Fabric,
    wearer: WearerGeometry,
    *,
    vertex_count: int | None = None,
    settings: InverseSettings | None = None,
    locks: tuple[str, ...] = (),
    rotation: SteadyRotation | None = None,
    hooks: Hooks = SILENT,
) -> InverseFit:
    """Recover a pattern as the thesis does: descend through the simulator from the graded pattern's drape.

    Args:
        garment: The graded pattern's mesh, nodes at its drape, contours named.
        target: The scan's surface with named contours.
        like: The template: tells symmetry, which seams are gathered and which corners are to stay.
        fabric: The cloth to begin with.
        wearer: The wearer's geometry.
        vertex_count: Vertices of the recovered pattern's mesh, or None for as many as there are.
        settings: Weights and steps.
        locks: What stays as it is given: `fabric`, `panel:NAME` (and its mirror image).
        rotation: The rotation in which the cloth was scanned, or None for cloth at rest.
        hooks: Progress, cancellation and checkpoints.

    Raises:
        LockUnknown: where a lock names no panel of the pattern.
    """
    from ..simulate import Scene, Topology, equilibrium

    settings = settings or InverseSettings()
    held = find_held(garment.pattern, like, locks)
    count = min(settings.vertices, len(garment.nodes))
    coarse = remesh_and_transfer(garment.pattern, count, garment, garment.nodes, wearer.body)
    pins = pin_waist(coarse, target)
    problem = DescentProblem.of(coarse, target, like, fabric, wearer.grid, pins, settings, held, rotation)
    fit_fabric = "fabric" not in locks and settings.fabric_iterations > 0
    descent = descend(problem, hooks, fit_fabric)
    hooks.progress("fit", 0.9, "draping the recovered pattern")
    count = vertex_count or len(garment.nodes)
    fine = remesh_and_transfer(problem.pattern_of(descent.best), count, coarse, descent.best_nodes, wearer.body)
    found = problem.fabric_of(descent.best) if fit_fabric else fabric
    scene = Scene(Topology.from_garment(fine), found, wearer.grid, pin_waist(fine, target), rotation)
    drape = equilibrium(scene, fine.nodes, hooks=hooks)
    warnings = () if drape.converged else (f"the simulation mesh is {drape.outcome.advice}",)
    simulation = project_outside(drape.nodes, wearer.exposed, fine.faces)
    return InverseFit(
        garment=fine.at(simulation),
        graded=resample(garment, garment.nodes, fine),
        simulation=simulation,
        descent=descent,
        fabric=found,
        estimates=_state_fabric(found) if fit_fabric else (),
        nearest=nearest_fabrics(found),
        warnings=warnings,
    )


def _state_fabric(fabric: Fabric) -> tuple[FabricEstimate, ...]:
    """State the found stiffnesses with the prior's spread: a descent says where it ended, not how sure that is."""
    note = "descended to; how well it is known was not asked (the hybrid method tells)"
    spreads = {name: ratio_prior(name, MaterialSettings())[1] for name in STIFFNESSES}
    found = (FabricEstimate(n, getattr(fabric, n), spreads[n], spreads[n], False, note) for n in STIFFNESSES)
    return (*found, state_density(fabric))
