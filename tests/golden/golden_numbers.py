"""What is measured of a golden scene: numbers by name, each with its unit in it, and words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from garmentq.core.body.body import Body
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.garment.curves import edge_points, panel_area
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import Pattern
from garmentq.core.people.separation import LabelledPerson
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.recover.recovery import Recovery
from garmentq.core.run.verdict import Gate

CM = 100.0

FIT = (
    "surface_rms_mm.s2t", "surface_rms_mm.t2s", "graded.surface_rms_mm.s2t", "sim.surface_rms_mm.s2t",
    "sim.surface_rms_mm.t2s", "redrape.surface_rms_mm.s2t", "normal_cosine", "stretch_p001", "stretch_p999",
    "body_penetration_mm", "panel_area_error", "panel_area_error_all", "panel_outline_mm", "gather_ratio_error",
)  # fmt: skip
"""Metrics of a recovery beside its truth that a scene holds; those that it lacks are left out."""


WAY = (
    "iterations", "residual", "residual_rms", "residual_weights", "seconds", "seconds_per_frame", "steps_per_frame",
    "peak_mb",
)  # fmt: skip
"""Last words of metrics that may differ between machines while the result is the same."""


@dataclass(frozen=True)
class Measured:
    """Describe what was measured of a scene.

    Attributes:
        numbers: By name; a unit is the name's last word.
        words: What is one of a closed set: category, template, verdicts.
    """

    numbers: Mapping[str, float]
    words: Mapping[str, str] = field(default_factory=dict)

    def __or__(self, other: Measured) -> Measured:
        """Return both together."""
        return Measured({**self.numbers, **other.numbers}, {**self.words, **other.words})


def pick(metrics: Mapping[str, float | None], names: Iterable[str]) -> Measured:
    """Return the metrics of some names that have a value."""
    return Measured({name: float(value) for name in names if (value := metrics.get(name)) is not None})


def measure_all(metrics: Mapping[str, float | None]) -> Measured:
    """Return all metrics that have a value, but for those that tell of a solver's way or of a machine's speed."""
    return pick(metrics, (name for name in metrics if name.split(".")[-1] not in WAY))


def measure_pattern(pattern: Pattern) -> Measured:
    """Return the area, width and height of each panel and the length of each seam's first side, summed."""
    numbers: dict[str, float] = {}
    for panel in pattern.panels:
        outline = np.concatenate([edge_points(panel, n, 12) for n in range(len(panel.edges))])
        width, height = CM * np.ptp(outline, axis=0)
        numbers |= {
            f"{panel.name}.area_cm2": CM**2 * panel_area(panel),
            f"{panel.name}.width_cm": float(width),
            f"{panel.name}.height_cm": float(height),
        }
    sides = [edge_points(pattern.panel(seam.a.panel), seam.a.edge, 12) for seam in pattern.seams]
    lengths = [np.linalg.norm(np.diff(points, axis=0), axis=1).sum() for points in sides]
    return Measured({**numbers, "seams_cm": CM * float(np.sum(lengths))})


def measure_draft(pattern: Pattern) -> Measured:
    """Return the area of all panels, the length of all seams, and that of the edges of each contour."""
    found = measure_pattern(pattern)
    areas = [value for name, value in found.numbers.items() if name.endswith(".area_cm2")]
    lengths: dict[str, float] = {}
    for panel in pattern.panels:
        for n, edge in enumerate(panel.edges):
            if edge.contour:
                points = edge_points(panel, n, 12)
                length = CM * float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
                lengths[f"{edge.contour}_cm"] = lengths.get(f"{edge.contour}_cm", 0.0) + length
    return Measured({"area_cm2": float(np.sum(areas)), "seams_cm": found.numbers["seams_cm"], **lengths})


def measure_contours(garment: Garment) -> Measured:
    """Return the length of each named contour of a garment's mesh."""
    numbers = {}
    for contour in garment.contours:
        points = garment.nodes[contour.vertices]
        numbers[f"{contour.name}.length_cm"] = CM * float(np.linalg.norm(points - np.roll(points, -1, 0), axis=1).sum())
    return Measured(numbers)


def measure_body(body: Body) -> Measured:
    """Return a wearer's girths and height."""
    own = measure_wearer(body)
    return Measured(
        {
            "body.bust_cm": CM * own.bust,
            "body.waist_cm": CM * own.waist,
            "body.hip_cm": CM * own.hip,
            "body.shoulders_cm": 2.0 * CM * own.shoulder_half_width,
            "body.height_cm": CM * float(np.ptp(body.vertices[:, 1])),
        }
    )


def measure_fabric(fabric: Fabric) -> Measured:
    """Return the logarithms of a fabric's bending and stretching stiffness, and its weight."""
    return Measured(
        {
            "fabric.ln_bending": float(np.log(fabric.k)),
            "fabric.ln_stretch": float(np.log(fabric.H00)),
            "fabric.density_g_m2": 1e3 * fabric.density,
        }
    )


def measure_gates(gates: Iterable[Gate]) -> Measured:
    """Return the verdict of each gate, and where it fails."""
    kept = list(gates)
    limits = {f"gate.{gate.name}.limit": float(gate.limit) for gate in kept}
    return Measured(limits, {f"gate.{gate.name}": str(gate.verdict) for gate in kept})


def measure_recovery(recovery: Recovery, metrics: Mapping[str, float | None]) -> Measured:
    """Return what a scene holds of a recovery.

    Args:
        recovery: The recovery.
        metrics: Its metrics beside the truth.
    """
    words = {
        "category": recovery.target.category,
        "template": recovery.template,
        "cut": str(recovery.report.manifest["cut"]),
    }
    return (
        Measured({}, words)
        | pick(metrics, FIT)
        | measure_pattern(recovery.pattern)
        | measure_contours(recovery.garment)
        | measure_body(recovery.body)
        | measure_fabric(recovery.fabric)
        | measure_gates(recovery.report.gates)
    )


def measure_separation(separation: LabelledPerson, truth: np.ndarray, true_body: np.ndarray) -> Measured:
    """Return how labels, outfit and body of a person taken apart compare with the truth.

    Args:
        separation: What was found.
        truth: True part of each point, shape [n].
        true_body: Vertices of the true body, in the built-in body's topology [m], shape [m, 3].
    """
    from garmentq.cli.bench.raw_labels import measure_calibration, measure_labels
    from garmentq.core.geometry.surface import TriangleSurface

    score = measure_labels(truth, separation.label)
    calibration = measure_calibration(truth, separation.label, separation.confidence)
    gaps = TriangleSurface(separation.body.vertices, separation.body.faces).distance(true_body)
    numbers = {
        "labels.accuracy": score.accuracy,
        "labels.cloth_iou": float(score.cloth_iou or 0.0),
        "labels.mean_iou": score.mean_iou,
        "labels.calibration_error": calibration.error,
        "labels.sure": calibration.sure,
        "body.gap_mean_mm": 1e3 * float(np.mean(np.abs(gaps))),
        "body.gap_p95_mm": 1e3 * float(np.quantile(np.abs(gaps), 0.95)),
    }
    numbers |= {f"labels.iou.{part}": value for part, value in score.part_iou.items()}
    outfit = ", ".join(f"{each.part.word}:{each.category}" for each in separation.garments)
    for each in separation.garments:
        numbers |= {f"{each.part.word}.{one.name}.confidence": one.confidence for one in each.contours}
        numbers |= {f"{each.part.word}.confidence": each.confidence}
    problem = "none" if separation.problem is None else separation.problem.code
    return Measured(numbers, {"outfit": outfit, "problem": problem}) | measure_body(separation.body)
