"""Find the best of fits from many headings and poses: the best of each round go on at a smaller scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.geometry import vertex_areas
from ..run.hooks import Hooks
from .fit import FitStage, FitState, Fitter, OrientedPoints
from .template import Template, articulate

Start = tuple[float, int, FitState]
"""A fit in progress: residual, number of its start, and state."""

STAGE = "body"
"""Name under which progress is reported."""

START_HEADING_COUNT = 8
"""Number of headings of every start pose. A fit corrects half the angle between two of them."""

POSES: dict[str, dict[str, tuple[float, float, float]]] = {
    "T": {},
    "A": {"left_shoulder": (0, 0, -0.8), "right_shoulder": (0, 0, 0.8)},
    "arms down": {"left_shoulder": (0, 0, -1.25), "right_shoulder": (0, 0, 1.25)},
    "left forward": {
        "left_hip": (-0.5, 0, 0), "right_hip": (0.3, 0, 0), "right_knee": (0.4, 0, 0), "left_elbow": (0, -0.5, 0),
        "right_elbow": (0, 0.5, 0), "left_shoulder": (0, 0, -0.4), "right_shoulder": (0, 0, 0.4),
    },
    "right forward": {
        "right_hip": (-0.5, 0, 0), "left_hip": (0.3, 0, 0), "left_knee": (0.4, 0, 0), "left_elbow": (0, -0.5, 0),
        "right_elbow": (0, 0.5, 0), "left_shoulder": (0, 0, -0.4), "right_shoulder": (0, 0, 0.4),
    },
    "seated": {
        "left_hip": (-1.4, 0, 0.1), "right_hip": (-1.4, 0, -0.1), "left_knee": (1.4, 0, 0), "right_knee": (1.4, 0, 0),
        "left_shoulder": (0, -0.3, -1.0), "right_shoulder": (0, 0.3, 1.0), "left_elbow": (0, -0.6, 0),
        "right_elbow": (0, 0.6, 0),
    },
}  # fmt: skip
"""Start poses as axis-angles [rad] of the joints that differ from the T-pose."""

MAX_SAME_FIT_DISTANCE = 0.1
"""Distance of two fits' joints (RMS) up to which they are the same fit [m]: converged fits agree within 3 cm, a person
turned about differs by 20 to 35 cm at shoulders and hips."""


@dataclass(frozen=True)
class SearchSettings:
    """Describe the rounds of the search for a start.

    Attributes:
        coarse_count: Number of points on either side while many starts compete: a few per limb segment distinguish
            them.
        fine_count: Number of template points in the last round.
        kept: Number of starts in the second, third and last rounds; in the last in addition to the best of every other
            distinct fit: under a long dress the first 3 were the same fit, which faced backward.
        stages: First, second, third and last rounds, from large to small scale.
        ranking: Scales of the residuals by which starts are ranked after these rounds [m]: those of their last steps.
    """

    coarse_count: int = 350
    fine_count: int = 1000
    kept: tuple[int, int, int] = (32, 8, 3)
    stages: tuple[tuple[FitStage, ...], ...] = (
        (FitStage(3, 0.30, 0.15, False, 4),),
        (FitStage(3, 0.20, 0.15, False, 4), FitStage(4, 0.15, 0.15, False, 8)),
        (FitStage(10, 0.10, 0.15, False, 10), FitStage(10, 0.06, 0.10, True, 15)),
        (FitStage(10, 0.05, 0.10, True, 20),),
    )
    ranking: tuple[float, float, float, float] = (0.15, 0.1, 0.05, 0.03)


def rank_starts(
    template: Template,
    surface: OrientedPoints,
    subset: np.ndarray,
    starts: list[FitState],
    search: SearchSettings,
    hooks: Hooks,
) -> list[Start]:
    """Return the fits of the last round, the best first.

    Args:
        template: The body.
        surface: Points of the scan; the first `coarse_count` are used while many starts compete.
        subset: Vertices of the template, likewise.
        starts: All starts.
        search: Rounds.
        hooks: Progress and cancellation, called at every fit.
    """
    coarse = Fitter(template, subset[: search.coarse_count], surface.take(slice(search.coarse_count)))
    ranked: list[Start] = [(0.0, i, state) for i, state in enumerate(starts)]
    for k, kept in enumerate((len(starts), *search.kept[:-1])):
        going = []
        for entry in ranked[:kept]:
            hooks.progress(STAGE, 0.15 * k, "trying headings and poses")
            going.append(_run_stages(coarse, search.stages[k], entry, search.ranking[k]))
        ranked = sorted(going, key=lambda entry: entry[:2])
    best = ranked[: search.kept[-1]]
    fine = Fitter(template, subset, surface)
    finalists = []
    for entry in best + find_distinct_fits(template, best, ranked[search.kept[-1] :]):
        hooks.progress(STAGE, 0.5, "comparing the best starts")
        finalists.append(_run_stages(fine, search.stages[-1], entry, search.ranking[-1]))
    return sorted(finalists, key=lambda entry: entry[:2])


def find_distinct_fits(template: Template, best: list[Start], rest: list[Start]) -> list[Start]:
    """Return the best of each distinct fit among the rest, other than those before it."""
    seen, others = [_joints(template, entry[2]) for entry in best], []
    for entry in rest:
        joints = _joints(template, entry[2])
        if min(float(np.sqrt(((joints - other) ** 2).sum(axis=1).mean())) for other in seen) > MAX_SAME_FIT_DISTANCE:
            seen.append(joints)
            others.append(entry)
    return others


def _joints(template: Template, state: FitState) -> np.ndarray:
    """Return the posed joints of a fit [m], shape [24, 3]."""
    _, joints = template.shaped(state.shape)
    return articulate(state.rotations, joints, state.translation)[1]


def _run_stages(fitter: Fitter, stages: tuple[FitStage, ...], entry: Start, scale: float) -> Start:
    """Return a start after some stages, with its residual at a scale [m]."""
    state = entry[2]
    for stage in stages:
        state = fitter.fit(state, stage)
    return fitter.residual(state, scale, scale), entry[1], state


def spread_subset(template: Template, count: int, rng: np.random.Generator) -> np.ndarray:
    """Draw indices of vertices in proportion to their area."""
    area = vertex_areas(template.vertices, template.faces)
    return rng.choice(len(area), count, replace=False, p=area / area.sum())
