"""Find the heading and pose of a person by fits as if bare, from which later fits continue."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import pi
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ..run.hooks import Hooks
from .body import JOINTS
from .competing_starts import (
    POSES,
    START_HEADING_COUNT,
    SearchSettings,
    find_distinct_fits,
    rank_starts,
    spread_subset,
)
from .fit import FitState, OrientedPoints
from .skinning import skin
from .template import Template, articulate, rotations_of, transforms_of

MORE_POSES: dict[str, dict[str, tuple[float, float, float]]] = {
    "arms up": {"left_shoulder": (0, 0, 1.2), "right_shoulder": (0, 0, -1.2)},
    "goalpost": {
        "left_shoulder": (-1.4, 0, 0), "right_shoulder": (-1.4, 0, 0), "left_elbow": (0, -1.5, 0),
        "right_elbow": (0, 1.5, 0),
    },
    "hands on hips": {
        "left_shoulder": (0.9, 0.3, -0.8), "right_shoulder": (0.9, -0.3, 0.8), "left_elbow": (0, -1.7, 0),
        "right_elbow": (0, 1.7, 0),
    },
    "crossed": {
        "left_shoulder": (0, -0.5, -1.1), "right_shoulder": (0, 0.5, 1.1), "left_elbow": (0, -1.7, 0),
        "right_elbow": (0, 1.7, 0),
    },
}  # fmt: skip
"""Start poses of persons, in addition to those of a body's mesh."""


POSE_FILE = Path(__file__).parent / "assets" / "poses.npz"
"""Poses out of motions, as different as they can be (`training/build_poses.py`)."""

MOVING_START_COUNT = 24
"""Number of starts from poses out of motions that are fitted: a quarter of those from named poses."""

COARSE_POINT_COUNT = 150
"""Number of points on either side by which poses out of motions are ranked before any is fitted: six a bone."""

MAX_COARSE_DISTANCE = 0.2
"""Distance [m] at which the coarse ranking clamps the misfit of a point: a limb that is elsewhere."""

HEIGHT_RANGE = (0.9, 2.0)
"""Statures [m] of starts from poses out of motions: children from three years on."""


@dataclass(frozen=True)
class FoundStart:
    """Describe the best fit as if bare.

    Attributes:
        state: The fit.
        residual: Its robust two-way misfit [m].
        margin: Excess misfit of the best other fit, relative to this one's; infinite where there is none.
    """

    state: FitState
    residual: float
    margin: float


def find_start(
    template: Template, surface: OrientedPoints, search: SearchSettings, seed: int, hooks: Hooks
) -> FoundStart:
    """Find the best fit from all named poses at all headings, and from the likeliest poses out of motions."""
    rng = np.random.default_rng(seed)
    subset = spread_subset(template, search.fine_count, rng)
    starts = list_starts(template, surface, subset)
    starts += rank_poses(template, surface, subset[:COARSE_POINT_COUNT])
    finalists = rank_starts(template, surface, subset, starts, search, hooks)
    others = find_distinct_fits(template, finalists[:1], finalists[1:])
    margin = others[0][0] / finalists[0][0] - 1.0 if others else np.inf
    return FoundStart(finalists[0][2], finalists[0][0], float(margin))


def list_starts(template: Template, surface: OrientedPoints, subset: np.ndarray) -> list[FitState]:
    """Return every start: each pose at each heading, scaled to the points' height and placed where they stand."""
    low, high = np.quantile(surface.points[:, 1], (0.002, 0.998))
    centre = 0.5 * (np.quantile(surface.points, 0.02, axis=0) + np.quantile(surface.points, 0.98, axis=0))
    usual = float(np.ptp(template.vertices[:, 1]))
    starts = []
    for angles in (*POSES.values(), *MORE_POSES.values()):
        vectors = np.zeros((24, 3))
        for joint, vector in angles.items():
            vectors[JOINTS.index(joint)] = vector
        posed = pose_points(template, np.zeros(4), rotations_of(vectors), subset)
        height = float(np.clip((high - low) / np.ptp(posed[:, 1]) * usual, 1.4, 2.0))
        shape = shape_of_stature(template, height)
        for turn in list_headings():
            turned = vectors.copy()
            turned[0] = (0.0, turn, 0.0)
            rotations = rotations_of(turned)
            posed = pose_points(template, shape, rotations, subset)
            shift = centre - 0.5 * (posed.min(axis=0) + posed.max(axis=0))
            shift[[0, 2]] = (surface.points.mean(axis=0) - posed.mean(axis=0))[[0, 2]]
            starts.append(FitState(shape, rotations, shift))
    return starts


@cache
def load_poses() -> tuple[np.ndarray, np.ndarray]:
    """Return poses out of motions as axis-angles [rad], shape [n, 24, 3], and the name of each one's motion."""
    with np.load(POSE_FILE) as kept:
        return kept["angles"].astype(np.float64), kept["clips"]


def rank_poses(template: Template, surface: OrientedPoints, subset: np.ndarray) -> list[FitState]:
    """Return the likeliest starts from poses out of motions, one heading of each, the best first.

    A start is scaled to the scan's spread about its mean and placed there. Its misfit is the mean distance of points of
    the body to the scan and back, each clamped to `MAX_COARSE_DISTANCE`.
    """
    points = surface.points[:: max(1, len(surface.points) // COARSE_POINT_COUNT)]
    mean = surface.points.mean(axis=0)
    spread = float(np.sqrt(((surface.points - mean) ** 2).sum(axis=1).mean()))
    tree = cKDTree(surface.points)
    usual = float(np.ptp(template.vertices[:, 1]))
    headings = rotations_of(np.array([[0.0, turn, 0.0] for turn in list_headings()]))
    posed = _pose_all(template, subset)
    radius = np.sqrt((posed**2).sum(axis=2).mean(axis=1))
    heights = np.clip(usual * spread / radius, *HEIGHT_RANGE)
    placed = np.einsum("hab,pnb->phna", headings, posed * (heights / usual)[:, None, None]) + mean
    there = np.minimum(tree.query(placed, distance_upper_bound=MAX_COARSE_DISTANCE)[0], MAX_COARSE_DISTANCE)
    back = np.stack([_clamp_distances(points, each.reshape(-1, *each.shape[-2:])) for each in placed])
    misfit = there.mean(axis=2) + back
    turn = misfit.argmin(axis=1)
    best = misfit.min(axis=1)
    starts = []
    for number in np.argsort(best, kind="stable")[:MOVING_START_COUNT]:
        h, height = turn[number], float(heights[number])
        rotations = rotations_of(load_poses()[0][number])
        rotations[0] = headings[h] @ rotations[0]
        shape = shape_of_stature(template, height)
        starts.append(FitState(shape, rotations, mean - pose_points(template, shape, rotations, subset).mean(axis=0)))
    return starts


def _pose_all(template: Template, subset: np.ndarray) -> np.ndarray:
    """Return the mean body's points in each pose out of motions, about their mean [m], shape [pose_count, m, 3]."""
    posed = np.stack([pose_points(template, np.zeros(4), rotations_of(angles), subset) for angles in load_poses()[0]])
    return np.asarray(posed - posed.mean(axis=1, keepdims=True))


def _clamp_distances(points: np.ndarray, bodies: np.ndarray) -> np.ndarray:
    """Compute the mean distance of points, shape [k, 3], to each of some bodies [h, m, 3], clamped [m], shape [h].

    |p - b|^2 = |p|^2 - 2 p b + |b|^2 for all pairs at once, as both are few.
    """
    centre = points.mean(axis=0)
    near, far = points - centre, bodies - centre
    squares = (near**2).sum(axis=1)[:, None] + (far**2).sum(axis=2)[:, None] - 2.0 * near @ far.transpose(0, 2, 1)
    return np.asarray(np.sqrt(squares.min(axis=2).clip(0.0, MAX_COARSE_DISTANCE**2)).mean(axis=1))


def list_headings() -> list[float]:
    """Return the headings of every start pose [rad]."""
    return [2 * pi * h / START_HEADING_COUNT for h in range(START_HEADING_COUNT)]


def shape_of_stature(template: Template, stature: float) -> np.ndarray:
    """Return the first four shape coefficients of the most probable body of a stature [m], shape [4]."""
    slope = template.directions[:, template.vertices[:, 1].argmax(), 1]
    usual = float(np.ptp(template.vertices[:, 1]))
    return np.asarray((slope * (stature - usual) / (slope @ slope))[:4])


def pose_points(template: Template, shape: np.ndarray, rotations: np.ndarray, subset: np.ndarray) -> np.ndarray:
    """Return some vertices of the body of a shape in a pose, its pelvis in the T-pose's place [m], shape [m, 3]."""
    rest, joints = template.shaped(shape)
    world, posed = articulate(rotations, joints, np.zeros(3))
    return skin(rest[subset], template.weights[subset], transforms_of(world, posed, joints))
