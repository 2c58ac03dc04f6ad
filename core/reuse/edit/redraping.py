"""Drape an edited pattern from where the present garment hangs, and judge it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...cloth.fabric import Fabric
from ...cloth.locking import reduce_membrane_stiffness
from ...cloth.statics import Drape
from ...garment.curves import panel_area
from ...garment.garment import Garment
from ...garment.node_transfer import transfer_nodes
from ...garment.pattern import Pattern
from ...garment.sewing import mesh_pattern
from ...judge.patterns import measure_seams
from ...recover.drape.stage import DrapeSettings, drape_graded, redrape
from ...recover.drape.waist import flat_length
from ...recover.drape.wearer import WearerGeometry
from ...run.clock import Clock
from ...run.hooks import Hooks
from ...run.report import ResultReport
from ...run.verdict import Gate, Verdict
from ...scan.contours.target import Contour
from ..wear.dressing import measure_worn, tabulate_ease
from ..wear.ease import Ease, measure_ease
from ..wear.layer_separation import separate_layers
from ..wear.load import measure_pressure, measure_strain
from ..wear.verdicts import judge_wear
from ..wear.worn import WornGarment
from .compare import PatternDifference, compare_versions

STAGES = ("drape", "measure")
"""Stages of an edit, after those that read its input."""

WARM_START_SETTINGS = DrapeSettings(settle_steps=0, self_contact=True)
"""Drapes from where the cloth hangs: nodes do not move before the equilibrium search, so folds are kept."""

MAX_SEAM_MISMATCH_MM = 0.5
"""Largest difference in length of a seam's sides that passes [mm], as in the verdicts of a recovery."""

COLD_START_WARNING = "a panel is not in the present garment, so the pattern was draped from its placement."
"""Warning of a drape without a start."""


@dataclass(frozen=True)
class EditedGarment:
    """Describe a version of a result.

    Attributes:
        before: The garment that was edited, on its wearer.
        worn: The edited one at rest.
        drape: The equilibrium.
        is_warm: Whether the drape began where the garment hung; else it began at the panels' placement.
        difference: From the recovered pattern.
        ease: Garment and body at each place where cloth surrounds the body.
        strain: Largest principal strain of the cloth at each node, shape [node_count].
        pressure: Of the cloth on the body at each node [Pa], shape [node_count].
        report: Numbers, verdicts, warnings, cost, and what reproduces it.
    """

    before: WornGarment
    worn: WornGarment
    drape: Drape
    is_warm: bool
    difference: PatternDifference
    ease: tuple[Ease, ...]
    strain: np.ndarray
    pressure: np.ndarray
    report: ResultReport


def drape_edit(worn: WornGarment, pattern: Pattern, recovered: Pattern, clock: Clock) -> EditedGarment:
    """Drape an edited pattern on the wearer of the present garment, from where that hangs, in contact with itself.
    Fabric, wearer, waist and rotation are the present garment's.

    Args:
        worn: The present garment of a stored result.
        pattern: The edited pattern.
        recovered: The recovered pattern, with which the edited one is compared.
        clock: Times the stages.

    Raises:
        PatternFault: where the pattern cannot be meshed.
        Cancelled: where the clock's hooks cancel.
    """
    wearer = WearerGeometry(worn.body)
    with clock.stage("drape", "draping from where the garment hangs") as hooks:
        start = transfer_nodes(worn.garment, pattern)
        garment, drape = _drape(worn, pattern, start, wearer, hooks)
    with clock.stage("measure", "comparing with the recovered pattern"):
        now = replace(worn, garment=garment)
        ease, strain, pressure = measure_ease(garment, worn.body), measure_strain(now), measure_pressure(now, wearer)
        metrics = measure_worn(now, wearer, drape) | tabulate_ease(ease) | measure_seams(pattern)
        metrics |= {
            "strain_p99": float(np.quantile(strain, 0.99)),
            "pressure_p99_pa": float(np.quantile(pressure, 0.99)),
        }
        metrics |= _measure_change(worn.garment, garment, worn.fabric) | {"drape.warm": float(start is not None)}
        difference = compare_versions(pattern, recovered)
    warnings = [COLD_START_WARNING] if start is None else []
    warnings += [] if drape.at_rest else [f"the garment is {drape.advice}"]
    manifest = {"fabric": worn.fabric.name, "template": worn.template, "category": worn.category}
    return EditedGarment(
        before=worn,
        worn=now,
        drape=drape,
        is_warm=start is not None,
        difference=difference,
        ease=ease,
        strain=strain,
        pressure=pressure,
        report=ResultReport.of(clock, metrics, (*judge_wear(metrics), _judge_seams(metrics)), warnings, manifest),
    )


def _drape(
    worn: WornGarment, pattern: Pattern, start: Garment | None, wearer: WearerGeometry, hooks: Hooks
) -> tuple[Garment, Drape]:
    """Drape the edited garment from a start, or from its placement alone."""
    target, fabric = worn.target, worn.fabric
    if start is None:
        mesh = mesh_pattern(pattern, len(worn.garment.nodes))
        draped, drape = redrape(mesh, wearer, fabric, target, rotation=worn.rotation, hooks=hooks)
        start = mesh.at(draped.nodes)
    garment, drape = drape_graded(
        start, wearer, fabric, target, rotation=worn.rotation, settings=WARM_START_SETTINGS, hooks=hooks
    )
    nodes, drape = separate_layers(replace(worn, garment=garment), wearer, drape, hooks)
    return garment.at(nodes), drape


def _measure_change(before: Garment, now: Garment, fabric: Fabric) -> dict[str, float | None]:
    """Measure the change of each contour's worn length, and of the pattern's area."""
    found: dict[str, float | None] = {}
    for contour in now.contours:
        was = before.contour(contour.name)
        if was is not None:
            change = worn_length(now, contour, fabric) - worn_length(before, was, fabric)
            found[f"contour_change.{contour.name}_mm"] = 1e3 * change
    areas = [sum(panel_area(panel) for panel in one.pattern.panels) for one in (before, now)]
    return found | {"area_change_cm2": 1e4 * (areas[1] - areas[0])}


def worn_length(garment: Garment, contour: Contour, fabric: Fabric) -> float:
    """Return the length of a drape's contour in the real fabric [m], which tension stretches less than in the drape.

        L' = P - (1 - s) max(P - F, 0)

    A drape's membrane is s times as stiff as the fabric's (`reduce_membrane_stiffness`), so that the same tension
    stretches it 1 / s times as much: 1 % in a hem on the hips under a garment's weight is 0.1 % in poplin.

    Notation: P the length of the contour's polygon, F of the same cloth laid flat, s the share.
    """
    length = contour.curve(garment.nodes).length
    stretch = length - flat_length(garment, contour.vertices)
    return length - (1.0 - reduce_membrane_stiffness(fabric).H00 / fabric.H00) * max(stretch, 0.0)


def _judge_seams(metrics: dict[str, float | None]) -> Gate:
    """Judge whether both sides of every seam have the same length."""
    apart = metrics["seam_mismatch_mm"] or 0.0
    verdict = Verdict.PASS if apart <= MAX_SEAM_MISMATCH_MM else Verdict.DOUBTFUL
    message = f"The two sides of a seam differ by up to {apart:.2f} mm in length" + (
        "." if verdict is Verdict.PASS else ": make them equal, or mark the seam as gathered."
    )
    return Gate("seams", verdict, apart, MAX_SEAM_MISMATCH_MM, message)
