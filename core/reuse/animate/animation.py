"""Compute the frames of a garment on a moving wearer, each with its verdict."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...body.exposed import pinched_depth
from ...body.motion.track import LeadIn
from ...body.skinning import skin, unskin
from ...cloth.dynamics import ClothState
from ...geometry.intersections import self_intersections
from ...run.checkpoints import load, save
from ...run.hooks import SILENT_HOOKS, Hooks
from ..wear.worn import WornGarment
from .settings import AnimateBad, AnimateSettings, StepLimits
from .stage import AnimationScene, Cloth, PosedWearer

STAGE = "animate"
"""Name of the stage in progress."""

CHECKPOINT_FRAME_COUNT = 5
"""Number of frames in a checkpoint; a killed run resumes a few seconds back, after the last one."""

MAX_COORDINATE_COUNT = 200_000_000
"""Largest number of coordinates of all frames: 1.6 GB, an hour of 600 vertices or ten minutes of 4000 at 30 Hz."""


@dataclass(frozen=True)
class FrameVerdict:
    """Describe the verdict on one frame.

    Attributes:
        converged: Whether every step to it converged within the tolerance.
        depth: Deepest point of the cloth below the exposed skin, of points that are not pinched [m].
        crossings: Number of faces that cross another.
        steps: Steps from the frame before.
        factors: Matrices factored for them.
        seconds: CPU time of all that [s].
        pinched: Deepest point of cloth between intersecting parts of the body [m].
    """

    converged: bool
    depth: float
    crossings: int
    steps: int
    factors: int
    seconds: float
    pinched: float = 0.0


@dataclass(frozen=True)
class Animation:
    """Describe a garment in motion.

    Attributes:
        worn: The garment at the start.
        fps: Frames a second [1/s].
        times: Time of the motion at each frame [s], shape [frame_count].
        frames: Nodes [m], outside the wearer, shape [frame_count, node_count, 3].
        transforms: The wearer's, from rest space to each pose, shape [frame_count, 24, 4, 4].
        verdicts: One for each frame.
    """

    worn: WornGarment
    fps: float
    times: np.ndarray
    frames: np.ndarray
    transforms: np.ndarray
    verdicts: tuple[FrameVerdict, ...]

    def bodies(self, indices: np.ndarray | None = None) -> np.ndarray:
        """Return the wearer's mesh in some frames, all if None [m], shape [count, vertex_count, 3]."""
        body = self.worn.body
        rest = unskin(body.vertices, body.weights, body.transforms)
        chosen = self.transforms if indices is None else self.transforms[indices]
        return np.stack([skin(rest, body.weights, transforms) for transforms in chosen])


@dataclass(frozen=True)
class _StepCounts:
    """Count steps and factorisations; `converged` is True if all steps converged."""

    converged: bool = True
    steps: int = 0
    factors: int = 0

    def plus(self, other: _StepCounts) -> _StepCounts:
        """Return the sum of both."""
        return _StepCounts(self.converged and other.converged, self.steps + other.steps, self.factors + other.factors)


@dataclass(frozen=True)
class _FrameChunk:
    """Describe the frames of one checkpoint, and the cloth after the last of them."""

    nodes: np.ndarray
    velocities: np.ndarray
    anchors: np.ndarray
    folds: np.ndarray
    frames: np.ndarray
    verdicts: tuple[FrameVerdict, ...]

    @classmethod
    def of(cls, cloth: ClothState, frames: list[np.ndarray], verdicts: list[FrameVerdict]) -> _FrameChunk:
        """Return frames and the cloth after them."""
        assert cloth.folds is not None
        return cls(cloth.nodes, cloth.velocities, cloth.anchors, cloth.folds, np.stack(frames), tuple(verdicts))

    @property
    def cloth(self) -> ClothState:
        """Return the cloth after the last frame."""
        return ClothState(self.nodes, self.velocities, self.anchors, folds=self.folds)


def animate(worn: WornGarment, motion: LeadIn, settings: AnimateSettings, hooks: Hooks = SILENT_HOOKS) -> Animation:
    """Animate a garment on a moving wearer.

    From rest in the wearer's own pose, the wearer moves into the motion in `settings.lead` seconds, which are not
    delivered, by steps of their own (`lead_pace`); then follows a frame every 1 / fps seconds. Every delivered frame is
    moved out of the body (`project_outside`); the simulation continues from the undelivered state.

    Args:
        worn: The garment on the wearer.
        motion: The wearer's motion.
        settings: Frames and steps.
        hooks: Progress, cancellation, checkpoints: a killed run resumes, with a bit for bit equal result.

    Raises:
        AnimateBad: where there are more frames than can be kept.
    """
    times = list_times(motion, settings)
    if len(times) * worn.garment.nodes.size > MAX_COORDINATE_COUNT:
        raise AnimateBad(
            f"{len(times)} frames of {len(worn.garment.nodes)} vertices are too many: take a part of them."
        )
    stage = AnimationScene(worn, motion, settings)
    transforms = np.stack([stage.mover.transforms(motion.at(float(t))) for t in times])
    inputs = (worn.garment.nodes, worn.body.vertices, transforms, times, repr(worn.fabric), repr(settings))
    kept: list[_FrameChunk] = []
    while (chunk := load(hooks, f"{STAGE}.{len(kept)}", _FrameChunk, *inputs)) is not None:
        kept.append(chunk)
    done = sum(len(chunk.frames) for chunk in kept)
    start = kept[-1].cloth if kept else stage.start
    frames: list[np.ndarray] = []
    verdicts: list[FrameVerdict] = []
    for index, state, nodes, verdict in _run(stage, times, done, start, hooks):
        frames.append(nodes)
        verdicts.append(verdict)
        if len(frames) == CHECKPOINT_FRAME_COUNT or index == len(times) - 1:
            kept.append(_FrameChunk.of(state, frames, verdicts))
            save(hooks, f"{STAGE}.{len(kept) - 1}", kept[-1], *inputs)
            frames, verdicts = [], []
    return Animation(
        worn,
        settings.fps,
        times,
        np.concatenate([chunk.frames for chunk in kept]),
        transforms,
        tuple(verdict for chunk in kept for verdict in chunk.verdicts),
    )


def list_times(motion: LeadIn, settings: AnimateSettings) -> np.ndarray:
    """Return the time of each frame [s], the first `begin`, shape [frame_count].

    Raises:
        AnimateBad: where the motion ends before `begin`.
    """
    track = motion.track
    end = settings.end if settings.end is not None else settings.begin + 4.0 if track.loops else track.seconds
    if end < settings.begin:
        raise AnimateBad(f"the motion is over after {track.seconds:.2f} s; {AnimateBad().message}")
    count = int(np.floor((end - settings.begin) * settings.fps + 1e-6)) + (0 if track.loops else 1)
    return settings.begin + np.arange(max(count, 1)) / settings.fps


def _run(
    stage: AnimationScene, times: np.ndarray, done: int, state: ClothState, hooks: Hooks
) -> Iterator[tuple[int, ClothState, np.ndarray, FrameVerdict]]:
    """Yield index, cloth, delivered nodes and verdict of each frame that is not `done`. Each checkpoint's frames begin
    with a new matrix layout: the layout depends on which pairs touched before, which changes the last digits, and a
    resumed run does not know it. The lead-in belongs to the first checkpoint."""
    settings = stage.settings
    lead = int(np.ceil(settings.lead / settings.lead_pace.longest - 1e-9)) if done == 0 else 0
    path = [*(times[0] - settings.lead * np.arange(lead, 0, -1) / max(lead, 1)), *times[max(done - 1, 0) :]]
    now, started = stage.at(float(path[0]), state.nodes), time.process_time()
    cloth = Cloth(state, stage.layout)
    if done == 0 and lead == 0:
        yield 0, state, *_judge_frame(stage, state, now, _StepCounts(), started)
    for before, after in pairwise(path):
        index = int(np.searchsorted(times, after - 1e-9))
        name = "into the motion" if after < times[0] - 1e-9 else f"frame {index + 1} of {len(times)}"
        hooks.progress(STAGE, index / len(times), name)
        started = time.process_time()
        if index % CHECKPOINT_FRAME_COUNT == 0 and index > 0:
            cloth = Cloth(cloth.state, stage.layout)
        pace = settings.pace if before >= times[0] - 1e-9 else settings.lead_pace
        cloth, now, tally = _advance(stage, cloth, now, (float(before), float(after)), pace)
        if after >= times[0] - 1e-9:
            yield index, cloth.state, *_judge_frame(stage, cloth.state, now, tally, started)


def _advance(
    stage: AnimationScene, cloth: Cloth, now: PosedWearer, span: tuple[float, float], pace: StepLimits
) -> tuple[Cloth, PosedWearer, _StepCounts]:
    """Advance from one time [s] to another, in as many steps as the skin's motion requires."""
    count = stage.count_steps(now, cloth.state.nodes, span, pace)
    marks = [span[0] + (span[1] - span[0]) * n / count for n in range(count)] + [span[1]]
    tally = _StepCounts()
    for start, end in pairwise(marks):
        cloth, now, found = _step_with_halving(stage, cloth, now, (start, end), stage.settings.halvings)
        tally = tally.plus(found)
    return cloth, now, tally


def _step_with_halving(
    stage: AnimationScene, cloth: Cloth, now: PosedWearer, span: tuple[float, float], halvings: int
) -> tuple[Cloth, PosedWearer, _StepCounts]:
    """Take a step; repeat it in two halves if it does not converge."""
    then = stage.at(span[1], cloth.state.nodes)
    step = stage.step(cloth, now, then, span[1] - span[0])
    if step.converged or halvings == 0:
        return Cloth(step.state, step.layout), then, _StepCounts(step.converged, 1, step.factors)
    middle = 0.5 * (span[0] + span[1])
    cloth, now, first = _step_with_halving(stage, cloth, now, (span[0], middle), halvings - 1)
    cloth, now, second = _step_with_halving(stage, cloth, now, (middle, span[1]), halvings - 1)
    return cloth, now, _StepCounts(True, 0, step.factors).plus(first).plus(second)


def _judge_frame(
    stage: AnimationScene, state: ClothState, now: PosedWearer, tally: _StepCounts, started: float
) -> tuple[np.ndarray, FrameVerdict]:
    """Return a frame's nodes outside the wearer, and its verdict."""
    faces = stage.worn.garment.faces
    nodes = stage.deliver(state.nodes, now)
    deep, crossed = pinched_depth(nodes, faces, now.surface), len(self_intersections(nodes, faces))
    seconds = time.process_time() - started
    return nodes, FrameVerdict(tally.converged, deep.free, crossed, tally.steps, tally.factors, seconds, deep.exit)
