"""Dress a body in all garments of a person at once, each over the one before, and judge each of them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ...body.body import Body
from ...cloth.statics import Drape
from ...recover.drape.wearer import WearerGeometry
from ...run.clock import Clock
from ...run.report import ResultReport
from .dress_over import drape_in_order, drape_together
from .dressing import DressedGarment, drape_worn, judge_dressed, transfer_alone_to_body, transfer_to_body
from .raised_skin import measure_layers
from .worn import WornGarment

Metrics = dict[str, float | None]

SHARED_METRICS = ("drape.residual", "drape.residual_rms", "drape.iterations", "drape.at_rest")
"""Metrics of the equilibrium, which are common to all garments."""

MAXIMUM_METRICS = ("body_penetration_mm", "layers.depth_mm")
"""Metrics of which the outfit's is the largest of its garments'."""

SUMMED_METRICS = ("vertices", "faces", "self_intersecting_faces", "layers.crossing_faces")
"""Metrics of which the outfit's is the sum of its garments'."""


@dataclass(frozen=True)
class DressedOutfit:
    """Describe all garments of a person at rest together on a body.

    Attributes:
        garments: Each by its word (`upper`), from the innermost to the outermost.
        body: The wearer.
        drape: The equilibrium of all.
        report: Numbers, verdicts, warnings, cost, and what reproduces it.
    """

    garments: Mapping[str, DressedGarment]
    body: Body
    drape: Drape
    report: ResultReport


def dress_outfit(outfit: Mapping[str, WornGarment], body: Body, clock: Clock) -> DressedOutfit:
    """Dress a body in several garments, each in its own cloth over the one before, all at rest together.

    Args:
        outfit: The garments of stored results, by word, from the innermost to the outermost.
        body: The new wearer.
        clock: Times the stages.

    Raises:
        Cancelled: where the clock's hooks cancel.
    """
    wearer = WearerGeometry(body)
    with clock.stage("drape", "dressing the body in all garments") as hooks:
        if len(outfit) == 1:  # as in `dress_body`
            (only,) = outfit.values()
            alone, drape = drape_worn(transfer_alone_to_body(only, body, None), wearer, hooks)
            rest: tuple[WornGarment, ...] = (alone,)
        else:
            carried = [transfer_to_body(worn, body, None) for worn in outfit.values()]
            rest, drape = drape_together(drape_in_order(carried, wearer, hooks), wearer, hooks)
    judged = {}
    for place, ((word, before), now) in enumerate(zip(outfit.items(), rest, strict=True)):
        layers = _measure_over(rest[:place], now, wearer)
        judged[word] = judge_dressed(before, now, drape, wearer, clock, layers)
    return _combine_results(judged, body, drape, clock)


def _measure_over(below: tuple[WornGarment, ...], above: WornGarment, wearer: WearerGeometry) -> Metrics | None:
    """Measure a garment over those below it, the worst of all; None where nothing is below."""
    if not below:
        return None
    found = [measure_layers(one.garment, above.garment, wearer.exposed) for one in below]
    return {
        "layers.crossing_faces": sum(one["layers.crossing_faces"] or 0.0 for one in found),
        "layers.depth_mm": max(one["layers.depth_mm"] or 0.0 for one in found),
    }


def _combine_results(judged: Mapping[str, DressedGarment], body: Body, drape: Drape, clock: Clock) -> DressedOutfit:
    """Combine garments that were judged one by one to one result."""
    each = [one.report.metrics for one in judged.values()]
    metrics: Metrics = {name: each[0][name] for name in SHARED_METRICS} | {"garments": float(len(judged))}
    for name in (*MAXIMUM_METRICS, *SUMMED_METRICS):
        values = [value for one in each if (value := one.get(name)) is not None]
        if values:
            metrics[name] = max(values) if name in MAXIMUM_METRICS else sum(values)
    gates = [gate for gate in next(iter(judged.values())).report.gates if gate.name == "at_rest"]
    for word, one in judged.items():
        metrics |= {f"{word}.{name}": value for name, value in one.report.metrics.items() if name not in SHARED_METRICS}
        others = [gate for gate in one.report.gates if gate.name != "at_rest"]
        gates += [replace(gate, name=f"{word}.{gate.name}", message=f"{word}: {gate.message}") for gate in others]
    warnings = itertools.chain.from_iterable(one.report.warnings for one in judged.values())
    manifest = {"body": body.source, "garments": {word: one.report.manifest for word, one in judged.items()}}
    return DressedOutfit(judged, body, drape, ResultReport.of(clock, metrics, gates, warnings, manifest))
