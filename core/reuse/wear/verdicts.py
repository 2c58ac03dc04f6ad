"""Judge a garment on a body: at rest, outside the body, without crossings, and wide enough."""

from __future__ import annotations

from collections.abc import Mapping

from ...cloth.settings import MAX_REST_RESIDUAL
from ...run.verdict import Gate, Verdict

Metrics = Mapping[str, float | None]

MAX_WORN_DEPTH_MM = 1.0
"""Largest depth in the body that passes [mm]; it is not visible in a picture."""


def judge_wear(metrics: Metrics) -> tuple[Gate, ...]:
    """Judge the metrics of `measure_worn`."""
    residual, depth = metrics["drape.residual"] or 0.0, metrics["body_penetration_mm"] or 0.0
    crossed, rests = metrics["self_intersecting_faces"] or 0.0, bool(metrics["drape.at_rest"])
    return (
        Gate(
            "at_rest",
            Verdict.PASS if rests else Verdict.FAIL,
            residual,
            MAX_REST_RESIDUAL,
            "The garment is at rest."
            if rests
            else f"The garment is not at rest: the largest force left on a node is "
            f"{residual:.1f} times its weight; look at its picture, or dress a body that it fits.",
        ),
        Gate(
            "depth",
            Verdict.PASS if depth <= MAX_WORN_DEPTH_MM else Verdict.FAIL,
            depth,
            MAX_WORN_DEPTH_MM,
            f"The garment lies up to {depth:.1f} mm inside the body"
            + ("." if depth <= MAX_WORN_DEPTH_MM else ": it is too small, or the body's parts press it between them."),
        ),
        _judge_width(metrics),
        Gate(
            "crossings",
            Verdict.PASS if crossed == 0.0 else Verdict.FAIL,
            crossed,
            0.0,
            "No face passes through another."
            if crossed == 0.0
            else f"{crossed:.0f} faces pass through others: mend them before the mesh is simulated on.",
        ),
        *_judge_layers(metrics),
    )


def _judge_layers(metrics: Metrics) -> tuple[Gate, ...]:
    """Judge a garment over another one; nothing where it is worn alone."""
    crossed, depth = metrics.get("layers.crossing_faces"), metrics.get("layers.depth_mm")
    if crossed is None or depth is None:
        return ()
    crossed += metrics.get("under.self_intersecting_faces") or 0.0
    deepest = max(depth, metrics.get("under.body_penetration_mm") or 0.0)
    clear = crossed == 0.0 and deepest <= MAX_WORN_DEPTH_MM
    message = "It lies over the other garment."
    if not clear:
        message = (
            f"{crossed:.0f} faces of it and the garment below pass through the other or through themselves, or it lies "
            f"{depth:.1f} mm under that, or that in the body: change their order, or take a wider size."
        )
    return (Gate("layers", Verdict.PASS if clear else Verdict.FAIL, max(crossed, deepest), MAX_WORN_DEPTH_MM, message),)


def _judge_width(metrics: Metrics) -> Gate:
    """Judge the tightest place: cloth shorter than the body's girth stretches."""
    ease = {name[5:-3]: value for name, value in metrics.items() if name.startswith("ease.") and value is not None}
    least = min(ease.values(), default=0.0)
    if least >= 0.0:
        return Gate("width", Verdict.PASS, 0.0, 0.0, "The cloth is nowhere shorter than the body's girth.")
    tight = [f"{-value:.0f} mm at the {name.replace('_', ' ')}" for name, value in sorted(ease.items()) if value < 0.0]
    message = f"The garment is too small by {', '.join(tight)}: it stretches there."
    return Gate("width", Verdict.DOUBTFUL, -least, 0.0, message)
