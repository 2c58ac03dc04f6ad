"""Compare flat outlines: width, rigid fit, distance along corresponding edges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..segment import resample_loop
from .contours import closest_on_loop, distance_to_loop

EDGE_SAMPLES = 50
"""Points on each edge: 2 cm apart on the longest side of trousers."""

HEADINGS = 12
"""Starting angles of a fit without corresponding edges; a fit from 15 degrees off finds its way."""

FIT_SWEEPS = 15
"""Closest-point sweeps from each starting angle; enough to tell which one leads to the best fit."""

FINAL_SWEEPS = 300
"""Sweeps from the best start at most: closest points slide along the outline slowly before they settle."""

SETTLED = 1e-7
"""A sweep that moves no point by more than this [m] is the last."""


def resample_line(line: np.ndarray, count: int) -> np.ndarray:
    """Give points at equal arc length along an open polyline, both ends included [m], shape [count, 2]."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    wanted = np.linspace(0.0, arc[-1], count)
    return np.stack([np.interp(wanted, arc, line[:, k]) for k in range(2)], axis=1)


def polyline_length(line: np.ndarray) -> float:
    """Give the length of an open polyline [m]."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def fit_rigidly(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Turn and move points onto their counterparts by least squares, no scale, no mirror; shape [n, 2].

    Equation: the best angle is atan2(sum a x b, sum a . b) over the centred points a of the source and b of the target.
    """
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    return a @ _turn(angle).T + target.mean(axis=0)


def edge_rms(ours: Sequence[np.ndarray], truth: Sequence[np.ndarray]) -> float:
    """Measure the RMS distance [m] of corresponding edges after one rigid fit of the whole panel."""
    source = np.concatenate([resample_line(line, EDGE_SAMPLES) for line in ours])
    target = np.concatenate([resample_line(line, EDGE_SAMPLES) for line in truth])
    return float(np.sqrt(np.mean(np.sum((fit_rigidly(source, target) - target) ** 2, axis=1))))


def outline_rms(ours: np.ndarray, truth: np.ndarray) -> float:
    """Measure the symmetric closest-point RMS [m] of two closed outlines after the best rigid fit."""
    rough, rough_target = resample_loop(ours, 100), resample_loop(truth, 100)
    starts = []
    for heading in np.arange(HEADINGS) * 2.0 * np.pi / HEADINGS:
        moved = (rough - rough.mean(axis=0)) @ _turn(heading).T + rough_target.mean(axis=0)
        moved = _settle(moved, rough_target, FIT_SWEEPS)
        starts.append((_symmetric_rms(moved, rough_target), moved))
    best = min(starts, key=lambda start: start[0])[1]
    source, target = resample_loop(ours, 400), resample_loop(truth, 400)
    moved = _settle(_carry(rough, best, source), target, FINAL_SWEEPS)
    return _symmetric_rms(moved, target)


def _settle(moved: np.ndarray, target: np.ndarray, sweeps: int) -> np.ndarray:
    """Fit points to the closest points of a closed outline, again and again."""
    for _ in range(sweeps):
        before, moved = moved, fit_rigidly(moved, closest_on_loop(moved, target))
        if np.abs(moved - before).max() < SETTLED:
            break
    return moved


def _carry(before: np.ndarray, after: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Move points as a rigid fit moved others."""
    a, b = before - before.mean(axis=0), after - after.mean(axis=0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    return (points - before.mean(axis=0)) @ _turn(angle).T + after.mean(axis=0)


def _symmetric_rms(first: np.ndarray, second: np.ndarray) -> float:
    forward, backward = distance_to_loop(first, second), distance_to_loop(second, first)
    return float(np.sqrt(0.5 * (np.mean(forward**2) + np.mean(backward**2))))


def _turn(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
