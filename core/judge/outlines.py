"""Compare flat outlines: width, rigid fit, distance along corresponding edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..geometry.curves import ClosedCurve, resample_polyline
from ..geometry.rigid import RigidMotion, fit_rigid, plane_rotation

EDGE_SAMPLES = 50
"""Number of points on each edge: 2 cm apart on the longest side of trousers."""

FIT_START_COUNT = 12
"""Number of starting angles of a fit without corresponding edges; from 15 degrees off it converges."""

FIT_SWEEPS = 15
"""Number of closest-point iterations from each starting angle; enough to find the one with the best fit."""

FINAL_SWEEPS = 300
"""Largest number of iterations from the best start: points slide along the outline slowly."""

OUTLINE_FIT_TOLERANCE = 1e-7
"""Largest movement of a point at which the iteration ends [m]."""


def edge_rms(ours: Sequence[np.ndarray], truth: Sequence[np.ndarray]) -> float:
    """Measure the RMS distance [m] of corresponding edges after one rigid fit of the whole panel."""
    source = np.concatenate([resample_polyline(line, EDGE_SAMPLES) for line in ours])
    target = np.concatenate([resample_polyline(line, EDGE_SAMPLES) for line in truth])
    return float(np.sqrt(np.mean(np.sum((fit_rigid(source, target).apply(source) - target) ** 2, axis=1))))


@dataclass(frozen=True)
class OutlineFit:
    """Describe the best fit of one closed outline to another: symmetric closest-point RMS distance [m], and rigid
    motion."""

    rms: float
    motion: RigidMotion


def outline_rms(ours: np.ndarray, truth: np.ndarray) -> float:
    """Measure the symmetric closest-point RMS [m] of two closed outlines after the best rigid fit."""
    return fit_outline(ours, truth).rms


def fit_outline(ours: np.ndarray, truth: np.ndarray) -> OutlineFit:
    """Fit a closed outline [m], shape [n, 2], to another by a rigid motion."""
    own, other = ClosedCurve(ours), ClosedCurve(truth)
    rough, rough_target = own.resample(100), other.resample(100)
    starts = []
    for heading in np.arange(FIT_START_COUNT) * 2.0 * np.pi / FIT_START_COUNT:
        moved = (rough - rough.mean(axis=0)) @ plane_rotation(heading).T + rough_target.mean(axis=0)
        moved = _iterate_closest_points(moved, rough_target, FIT_SWEEPS)
        starts.append((_symmetric_rms(moved, rough_target), moved))
    best = min(starts, key=lambda start: start[0])[1]
    source, target = own.resample(400), other.resample(400)
    moved = _iterate_closest_points(fit_rigid(rough, best).apply(source), target, FINAL_SWEEPS)
    return OutlineFit(_symmetric_rms(moved, target), fit_rigid(source, moved))


def _iterate_closest_points(moved: np.ndarray, target: np.ndarray, sweeps: int) -> np.ndarray:
    """Fit points to the closest points of a closed outline iteratively."""
    outline = ClosedCurve(target)
    for _ in range(sweeps):
        before, moved = moved, fit_rigid(moved, outline.closest(moved).foot).apply(moved)
        if np.abs(moved - before).max() < OUTLINE_FIT_TOLERANCE:
            break
    return moved


def _symmetric_rms(first: np.ndarray, second: np.ndarray) -> float:
    forward, backward = ClosedCurve(second).distance(first), ClosedCurve(first).distance(second)
    return float(np.sqrt(0.5 * (np.mean(forward**2) + np.mean(backward**2))))
