"""Measure a finished recovery against a target pack's truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...core.body.exposed import ExposedSurface, penetration_depth
from ...core.cloth.fabric import Fabric
from ...core.geometry.curves import Curve
from ...core.geometry.surface import TriangleSurface
from ...core.judge.contours import curve_rms
from ...core.judge.fit import SURFACE_SAMPLES, Reference, measure_fit
from ...core.judge.patterns import measure_seams
from ...core.recover.recovery import Recovery
from ...core.run.units import MM_PER_M
from ...core.scan.contours.loop import find_loops
from ...core.scan.contours.target import Contour
from .packs import Pack, read_true_mesh, read_true_pattern
from .pattern_match import PATTERN_METRICS, is_same_cut, measure_pattern, unmatched_panels

FIT_FAMILIES = ("graded", "sim", "redrape", "surface_rms_mm", "surface_p95_mm", "contour_rms_mm", "gather_ratio_error")
"""First words of metrics whose names depend on the truth: a recovery's own values of them are dropped."""

REST_METRIC_SUFFIXES = ("residual", "residual_rms", "iterations", "at_rest")
"""Last words of the metrics of how far a drape is at rest (`Drape.measure`)."""

BODY_SAMPLES = 10_000
"""Number of samples of the true body: an RMS then scatters by about 2 %."""


def measure_recovery(
    recovery: Recovery, pack: Pack, own_template: bool, seed: int = 0, samples: int = SURFACE_SAMPLES
) -> tuple[dict[str, float | None], tuple[str, ...]]:
    """Measure the meshes against the pack's garment.ply as it is, and the pattern against pattern.json.

    Args:
        recovery: The recovery; its contours' names are transferred to the truth's own boundary loops.
        pack: The target.
        own_template: True if the pack's own template was the base pattern; otherwise the 2D metrics are None unless the
            wide panels of both patterns correspond one to one (`is_same_cut`).
        seed: Seed of the samples.
        samples: Surface samples per direction.

    Returns:
        The metrics, and the names of panels without a counterpart. The recovery's own metrics (the drape's residual,
        for example) are kept if they do not depend on the truth.
    """
    vertices, faces = read_true_mesh(pack)
    target = recovery.target
    contours = transfer_contours(target.contours, target.vertices, vertices, faces)
    truth = Reference(TriangleSurface(vertices, faces), contours, ExposedSurface.of(recovery.body), seed, samples)
    found = measure_fit(recovery.garment, recovery.meshes, truth)
    if pack.truth_body is not None:
        found |= _measure_body(recovery, pack)
    unmatched: tuple[str, ...] = ()
    pattern = read_true_pattern(pack)
    if pattern is not None:
        unmatched = unmatched_panels(recovery.pattern, pattern)
    if pattern is None or not (own_template or is_same_cut(recovery.pattern, pattern)):
        found |= dict.fromkeys(PATTERN_METRICS) | measure_seams(recovery.pattern)
    else:
        found |= measure_pattern(recovery.pattern, pattern, own_template)
    found |= measure_fabric(recovery.fabric, pack.fabric)
    metrics = {name: value for name, value in recovery.report.metrics.items() if not _is_of_truth(name)}
    return dict(sorted((metrics | found).items())), unmatched


def transfer_contours(
    contours: Sequence[Contour], positions: np.ndarray, vertices: np.ndarray, faces: np.ndarray
) -> tuple[Contour, ...]:
    """Transfer named contours to another mesh of the same surface: each to the nearest boundary loop.

    Args:
        contours: Named contours, indices into `positions`.
        positions: Vertices of the mesh with the names [m], shape [n, 3].
        vertices: Vertices of the other mesh [m], shape [m, 3].
        faces: Its faces, shape [face_count, 3].

    Returns:
        The contours with indices into `vertices`; untrusted ones too.
    """
    loops = find_loops(faces)
    carried = []
    for contour in contours:
        curve = contour.curve(positions)
        if loops and contour.is_closed:
            nearest = min(loops, key=lambda loop: curve_rms(curve, Curve(vertices[loop])))
            carried.append(replace(contour, vertices=nearest))
        elif loops:
            nearest = min(loops, key=lambda loop: float(Curve(vertices[loop]).distance(curve.points).max()))
            first, last = (
                int(np.linalg.norm(vertices[nearest] - end, axis=1).argmin()) for end in curve.points[[0, -1]]
            )
            carried.append(replace(contour, vertices=np.roll(nearest, -first)[: (last - first) % len(nearest) + 1]))
    return tuple(carried)


def _is_of_truth(name: str) -> bool:
    """Return whether a metric depends on the truth; how far a drape is at rest does not."""
    return name.split(".")[0] in FIT_FAMILIES and name.split(".")[-1] not in REST_METRIC_SUFFIXES


def measure_fabric(fabric: Fabric, truth: Mapping[str, float]) -> dict[str, float | None]:
    """Measure `material_log_error.NAME`, ln(estimate / truth), of each parameter whose true value is known.

    If the true weight is known too, also `material_log_error.NAME_by_density`, that of the ratio to the weight: only
    these ratios can be identified from a drape at rest.
    """
    errors = {name: float(np.log(getattr(fabric, name) / value)) for name, value in truth.items() if value > 0.0}
    found: dict[str, float | None] = {f"material_log_error.{name}": error for name, error in errors.items()}
    if "density" in errors:
        ratios = {name: error - errors["density"] for name, error in errors.items() if name != "density"}
        found |= {f"material_log_error.{name}_by_density": error for name, error in ratios.items()}
    return found


def _measure_body(recovery: Recovery, pack: Pack) -> dict[str, float | None]:
    """Measure the detail mesh and the estimated body against the true person below the cloth."""
    vertices, faces = read_true_mesh(pack, pack.truth_body)
    points, _ = TriangleSurface(vertices, faces).sample(BODY_SAMPLES, np.random.default_rng(0))
    distance = TriangleSurface(recovery.body.vertices, recovery.body.faces).distance(points)
    truth = ExposedSurface(vertices, faces)
    found_meshes = recovery.meshes
    meshes = {"": found_meshes.detail, "sim.": found_meshes.simulation, "redrape.": found_meshes.redraped}
    depths: dict[str, float | None] = {
        f"{prefix}truth_body_penetration_mm": MM_PER_M * penetration_depth(nodes, recovery.garment.faces, truth)
        for prefix, nodes in meshes.items()
        if nodes is not None
    }
    return depths | {
        "truth_body_rms_mm": MM_PER_M * float(np.sqrt(np.mean(distance**2))),
    }
