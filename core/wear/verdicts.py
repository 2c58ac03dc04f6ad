"""Judge a garment on a body: at rest, outside the body, through itself nowhere, and wide enough."""

from __future__ import annotations

from collections.abc import Mapping

from ..recovery import Gate

Metrics = Mapping[str, float | None]

DEPTH_MM = 1.0
"""Depth in the body that passes [mm]: nothing of it shows in a picture."""


def judge_wear(metrics: Metrics) -> tuple[Gate, ...]:
    """Judge what `measure_worn` measured."""
    residual, depth = metrics["drape.residual"] or 0.0, metrics["body_penetration_mm"] or 0.0
    crossed, rests = metrics["self_intersecting_faces"] or 0.0, bool(metrics["drape.at_rest"])
    return (
        Gate(
            "at_rest",
            "pass" if rests else "fail",
            residual,
            1.0,
            "The garment is at rest."
            if rests
            else f"The garment is not at rest: its least balanced node feels "
            f"{residual:.1f} times its own weight; look at its picture, or dress a body that it fits.",
        ),
        Gate(
            "depth",
            "pass" if depth <= DEPTH_MM else "fail",
            depth,
            DEPTH_MM,
            f"The garment lies up to {depth:.1f} mm inside the body"
            + ("." if depth <= DEPTH_MM else ": it is too small, or the body's parts press it between them."),
        ),
        Gate(
            "crossings",
            "pass" if crossed == 0.0 else "fail",
            crossed,
            0.0,
            "No face passes through another."
            if crossed == 0.0
            else f"{crossed:.0f} faces pass through others: mend them before the mesh is simulated on.",
        ),
    )
