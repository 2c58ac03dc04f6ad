"""Find the heading and pose of a person by fits as if bare, from which later fits continue."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

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
    """Find the best fit from all poses at all headings."""
    rng = np.random.default_rng(seed)
    subset = spread_subset(template, search.fine_count, rng)
    finalists = rank_starts(template, surface, subset, list_starts(template, surface, subset), search, hooks)
    others = find_distinct_fits(template, finalists[:1], finalists[1:])
    margin = others[0][0] / finalists[0][0] - 1.0 if others else np.inf
    return FoundStart(finalists[0][2], finalists[0][0], float(margin))


def list_starts(template: Template, surface: OrientedPoints, subset: np.ndarray) -> list[FitState]:
    """Return every start: each pose at each heading, scaled to the points' height and placed where they stand."""
    low, high = np.quantile(surface.points[:, 1], (0.002, 0.998))
    centre = 0.5 * (np.quantile(surface.points, 0.02, axis=0) + np.quantile(surface.points, 0.98, axis=0))
    usual = float(np.ptp(template.vertices[:, 1]))
    slope = template.directions[:, template.vertices[:, 1].argmax(), 1]
    starts = []
    for angles in (*POSES.values(), *MORE_POSES.values()):
        vectors = np.zeros((24, 3))
        for joint, vector in angles.items():
            vectors[JOINTS.index(joint)] = vector
        posed = _pose(template, np.zeros(4), rotations_of(vectors), subset)
        height = float(np.clip((high - low) / np.ptp(posed[:, 1]) * usual, 1.4, 2.0))
        shape = (slope * (height - usual) / (slope @ slope))[:4]
        for h in range(START_HEADING_COUNT):
            turned = vectors.copy()
            turned[0] = (0.0, 2 * pi * h / START_HEADING_COUNT, 0.0)
            rotations = rotations_of(turned)
            posed = _pose(template, shape, rotations, subset)
            shift = centre - 0.5 * (posed.min(axis=0) + posed.max(axis=0))
            shift[[0, 2]] = (surface.points.mean(axis=0) - posed.mean(axis=0))[[0, 2]]
            starts.append(FitState(shape, rotations, shift))
    return starts


def _pose(template: Template, shape: np.ndarray, rotations: np.ndarray, subset: np.ndarray) -> np.ndarray:
    rest, joints = template.shaped(shape)
    world, posed = articulate(rotations, joints, np.zeros(3))
    return skin(rest[subset], template.weights[subset], transforms_of(world, posed, joints))
