"""Dress a body in a recovered garment, the pattern unchanged: drape it from its rest placement, and judge it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...body.body import Body
from ...body.body_tape import tabulate_body
from ...body.exposed import penetration_depth
from ...cloth.fabric import Fabric
from ...cloth.statics import Drape
from ...garment.pieces.numbers import PieceNumbers, measure_pieces
from ...geometry.intersections import self_intersections
from ...recover.drape.stage import redrape
from ...recover.drape.wearer import WearerGeometry
from ...recover.drape.worn_contours import name_worn_contours
from ...run.clock import Clock
from ...run.hooks import Hooks
from ...run.report import ResultReport
from .ease import Ease, measure_ease
from .layer_separation import separate_layers
from .load import measure_pressure, measure_strain
from .verdicts import judge_wear
from .waist import is_same_body, transfer_curve
from .worn import WornGarment

STAGES = ("drape", "measure")
"""Stages of dressing, after those that read its input."""


@dataclass(frozen=True)
class DressedGarment:
    """Describe a garment on another body.

    Attributes:
        before: The garment on the wearer from whom it was recovered.
        worn: The garment at rest on the other body.
        drape: The equilibrium.
        ease: Garment and body at each place where cloth surrounds the body.
        strain: Largest principal strain of the cloth at each node, shape [node_count].
        pressure: Of the cloth on the body at each node [Pa], shape [node_count].
        report: Numbers, verdicts, warnings, cost, and what reproduces it.
        pieces: Numbers of each production piece of the pattern; empty if none can be cut.
        inner: The garment below it at rest with it, or None.
    """

    before: WornGarment
    worn: WornGarment
    drape: Drape
    ease: tuple[Ease, ...]
    strain: np.ndarray
    pressure: np.ndarray
    report: ResultReport
    pieces: tuple[PieceNumbers, ...] = ()
    inner: WornGarment | None = None


def dress_body(worn: WornGarment, body: Body, fabric: Fabric | None, clock: Clock) -> DressedGarment:
    """Dress a body in a worn garment, in its own cloth or another one, at rest under its weight.

    A garment of a rotating wearer rotates with the same wearer again; on another body it hangs at rest. It is draped
    like a recovery's re-draped mesh; layers that cross then are separated.

    Args:
        worn: The garment of a stored result.
        body: The new wearer.
        fabric: The cloth, or None for the garment's own.
        clock: Times the stages.

    Raises:
        Cancelled: where the clock's hooks cancel.
    """
    wearer = WearerGeometry(body)
    with clock.stage("drape", "dressing the body in the pattern") as hooks:
        now, drape = drape_worn(transfer_alone_to_body(worn, body, fabric), wearer, hooks)
    return judge_dressed(worn, now, drape, wearer, clock)


def transfer_to_body(worn: WornGarment, body: Body, fabric: Fabric | None) -> WornGarment:
    """Return a garment with another wearer: its waist moved to that body, its nodes unchanged.

    Args:
        worn: The garment of a stored result.
        body: The new wearer.
        fabric: The cloth, or None for the garment's own.
    """
    waist = None if worn.waist is None else transfer_curve(worn.waist, worn.body, body)
    return replace(worn, fabric=fabric or worn.fabric, body=body, waist=waist, rotation=None)


def transfer_alone_to_body(worn: WornGarment, body: Body, fabric: Fabric | None) -> WornGarment:
    """Return a garment as `transfer_to_body` does, to be worn alone: on its own wearer with its rotation."""
    carried = transfer_to_body(worn, body, fabric)
    return replace(carried, rotation=worn.rotation) if is_same_body(worn.body, body) else carried


def drape_worn(worn: WornGarment, wearer: WearerGeometry, hooks: Hooks) -> tuple[WornGarment, Drape]:
    """Drape a garment on its wearer from its pattern's rest placement, and separate its layers."""
    anew, drape = redrape(worn.garment, wearer, worn.fabric, worn.target, rotation=worn.rotation, hooks=hooks)
    draped = replace(worn, garment=worn.garment.at(anew.nodes))
    nodes, drape = separate_layers(draped, wearer, drape, hooks)
    return replace(draped, garment=draped.garment.at(nodes)), drape


def judge_dressed(
    before: WornGarment,
    draped: WornGarment,
    drape: Drape,
    wearer: WearerGeometry,
    clock: Clock,
    layers: dict[str, float | None] | None = None,
) -> DressedGarment:
    """Measure and judge the fit of a garment at rest on another body.

    Args:
        before: The garment on the wearer from whom it was recovered.
        draped: The garment at rest on the other one.
        drape: The equilibrium.
        wearer: The other one's geometry.
        clock: Times the stages.
        layers: Metrics of the garment over another one, or None where it is worn alone.
    """
    body = wearer.body
    with clock.stage("measure", "measuring how it fits"):
        contours = name_worn_contours(draped.garment, draped.garment.nodes, body)
        garment = draped.garment.at(draped.garment.nodes, contours or draped.garment.contours)
        now = replace(draped, garment=garment)
        ease, strain, pressure = measure_ease(garment, body), measure_strain(now), measure_pressure(now, wearer)
        cut = measure_pieces(now.pattern)
        metrics = {**measure_worn(now, wearer, drape), **tabulate_ease(ease), **cut.metrics, **(layers or {})}
        metrics |= tabulate_body(body)
        metrics |= {
            "strain_p99": float(np.quantile(strain, 0.99)),
            "pressure_p99_pa": float(np.quantile(pressure, 0.99)),
        }
    warnings = [] if drape.at_rest else [f"the garment is {drape.advice}"]
    if before.rotation is not None and draped.rotation is None:
        warnings.append("the scanned cloth was in motion; here it hangs at rest.")
    manifest = {"body": body.source, "fabric": now.fabric.name, "template": now.template, "category": now.category}
    return DressedGarment(
        before=before,
        worn=now,
        drape=drape,
        ease=ease,
        strain=strain,
        pressure=pressure,
        report=ResultReport.of(clock, metrics, judge_wear(metrics), warnings, manifest),
        pieces=cut.pieces,
    )


def measure_worn(worn: WornGarment, wearer: WearerGeometry, drape: Drape) -> dict[str, float | None]:
    """Measure rest, depth and crossings of a garment on its wearer; units in the names."""
    nodes, faces = worn.garment.nodes, worn.garment.faces
    return {
        "vertices": float(len(nodes)),
        "faces": float(len(faces)),
        **drape.measure("drape"),
        "body_penetration_mm": 1e3 * penetration_depth(nodes, faces, wearer.exposed),
        "self_intersecting_faces": float(len(self_intersections(nodes, faces))),
    }


def tabulate_ease(ease: tuple[Ease, ...]) -> dict[str, float | None]:
    """Return ease and both girths as metrics: `ease.chest_mm`, `girth.garment.chest_mm`, `girth.body.chest_mm`."""
    found: dict[str, float | None] = {}
    for one in ease:
        found[f"ease.{one.place}_mm"] = 1e3 * one.value
        found[f"girth.garment.{one.place}_mm"], found[f"girth.body.{one.place}_mm"] = 1e3 * one.garment, 1e3 * one.body
    return found
