"""Fit flat outlines to each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.curves import Curve
from ..geometry.rigid import RigidMotion, fit_rigid, plane_rotation


@dataclass(frozen=True)
class OutlineSettings:
    """Describe the fit of one closed outline to another.

    Attributes:
        starts: Number of starting angles; from 15 degrees off it converges.
        start_points, points: Number of points on an outline in the iterations from these angles, and thereafter.
        start_sweeps: Number of closest-point iterations from each of them; enough to find the one with the best fit.
        sweeps: Largest number of iterations from the best start: points slide along the outline slowly.
        tolerance: Largest movement of a point at which the iteration ends [m].
        max_lean: Largest angle from an expected rotation of a fit that is preferred to better ones [rad].
        preference: Ratio of distances up to which it is preferred: one turned further must be better by a third.
    """

    starts: int = 12
    start_points: int = 100
    start_sweeps: int = 15
    points: int = 400
    sweeps: int = 300
    tolerance: float = 1e-7
    max_lean: float = np.pi / 4.0
    preference: float = 1.5


@dataclass(frozen=True)
class OutlineFit:
    """Describe the best fit of one closed outline to another: symmetric closest-point RMS distance [m], and rigid
    motion."""

    rms: float
    motion: RigidMotion


def fit_outline(
    outline: np.ndarray,
    truth: np.ndarray,
    settings: OutlineSettings = OutlineSettings(),
    upright: float | None = None,
) -> OutlineFit:
    """Fit a closed outline [m], shape [n, 2], to another by a rigid motion.

    Args:
        outline: The outline that is moved.
        truth: The other one.
        settings: How it is fitted.
        upright: The rotation at which the grainlines of both agree [rad]: a fit near it is preferred. None for any.
    """
    curve, true_curve = Curve(outline), Curve(truth)
    rough, rough_target = curve.resample(settings.start_points), true_curve.resample(settings.start_points)
    starts = []
    for heading in np.arange(settings.starts) * 2.0 * np.pi / settings.starts:
        moved = (rough - rough.mean(axis=0)) @ plane_rotation(heading).T + rough_target.mean(axis=0)
        moved = _iterate_closest_points(moved, rough_target, settings.start_sweeps, settings.tolerance)
        starts.append((_symmetric_rms(moved, rough_target), moved))
    least, best = min(starts, key=lambda start: start[0])
    near = [start for start in starts if upright is not None and _leans(rough, start[1], upright) <= settings.max_lean]
    if near and min(near, key=lambda start: start[0])[0] <= settings.preference * least:
        best = min(near, key=lambda start: start[0])[1]
    source, target = curve.resample(settings.points), true_curve.resample(settings.points)
    moved = _iterate_closest_points(fit_rigid(rough, best).apply(source), target, settings.sweeps, settings.tolerance)
    return OutlineFit(_symmetric_rms(moved, target), fit_rigid(source, moved))


def _leans(source: np.ndarray, moved: np.ndarray, upright: float) -> float:
    """Return the angle between a fit's rotation and an expected one [rad], at most pi."""
    rotation = fit_rigid(source, moved).rotation
    angle = float(np.arctan2(rotation[1, 0], rotation[0, 0])) - upright
    return abs((angle + np.pi) % (2.0 * np.pi) - np.pi)


def _iterate_closest_points(moved: np.ndarray, target: np.ndarray, sweeps: int, tolerance: float) -> np.ndarray:
    """Fit points to the closest points of a closed outline iteratively."""
    outline = Curve(target)
    for _ in range(sweeps):
        before, moved = moved, fit_rigid(moved, outline.closest(moved).foot).apply(moved)
        if np.abs(moved - before).max() < tolerance:
            break
    return moved


def _symmetric_rms(first: np.ndarray, second: np.ndarray) -> float:
    forward, backward = Curve(second).distance(first), Curve(first).distance(second)
    return float(np.sqrt(0.5 * (np.mean(forward**2) + np.mean(backward**2))))
