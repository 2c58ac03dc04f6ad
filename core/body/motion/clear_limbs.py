"""Spread limbs that a motion would move into the rest of the wearer, or too close to it for the cloth between them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..body import JOINT_PARENTS, JOINTS, Body
from ..template import articulate
from .limb_gaps import MIN_GAP_WIDENING, Limb, LimbGaps
from .moving_body import MovingBody
from .track import Pose, Track

LIMB_GROUPS = {
    "left arm": (Limb.named("left", "shoulder"),),
    "right arm": (Limb.named("right", "shoulder"),),
    "legs": (Limb.named("left", "hip"), Limb.named("right", "hip")),
}
"""Limbs that one angle spreads: an arm from everything but the other arm, both legs from each other."""

CLOTH_LAYER_CLEARANCE = 2.5e-3
"""Room for a layer of cloth on covered skin [m]: half of what two layers need between two parts of a body, with their
distances from the skin and from each other (`core.judge.crossings.MAX_PINCH_DISTANCE`)."""

MAX_LIMB_SPREAD_ANGLE = np.deg2rad(15.0)
"""Largest angle by which a joint is turned [rad]; beyond it the motion is visibly another one."""

SPREAD_SMOOTHING_TIME = 0.25
"""Time before and after a pose in which its angle is reached and released [s]: half a step of a walk."""

SPREAD_SAMPLE_RATE = 30.0
"""Approximate rate at which poses are examined [1/s]. In between a limb moves 6 cm at most, and the largest angle
applies for a quarter of a second around each."""

MAX_SPREAD_ITERATIONS = 6
"""Largest number of iterations for a pose's angle. The nearest skin changes as a limb turns; 2 to 4 suffice."""

SPREAD_ANGLE_TOLERANCE = np.deg2rad(0.1)
"""Change of the angle at which the search ends [rad]."""

MIN_LEG_WEIGHT_SHARE = 0.3
"""Smallest share of a leg in the weights of its faces. The inner thigh has half of its weights from the pelvis."""


@dataclass(frozen=True)
class ClearedMotion:
    """Describe a motion whose limbs were spread.

    Attributes:
        track: The motion.
        angles: By which the limbs of `LIMB_GROUPS` are spread in each pose of the track [rad], shape [pose_count, 3].
        missed: Poses in which `MAX_LIMB_SPREAD_ANGLE` is too small to clear all, shape [pose_count, 3].
    """

    track: Track
    angles: np.ndarray
    missed: np.ndarray


def clear_limbs(track: Track, body: Body, covered: np.ndarray, begin: float, end: float) -> ClearedMotion:
    """Spread limbs so that they clear the rest of the wearer, as far as turning them outward does.

    In each pose every arm, and both legs together, turn outward by the least angle that leaves room for the cloth on
    the facing skins (`CLOTH_LAYER_CLEARANCE` for each covered one, 0 for bare skin), at most `MAX_LIMB_SPREAD_ANGLE`.
    Over time the largest angle within `SPREAD_SMOOTHING_TIME` applies, averaged over the same time: smooth and never
    less than needed. Feet keep their direction, and the lower one its height. Creases near joints are ignored.

    Args:
        track: The motion.
        body: The wearer.
        covered: Whether cloth covers each vertex, shape [vertex_count].
        begin: First time of interest [s].
        end: Last one [s]; poses that cannot influence this interval are not changed, unless the motion loops.
    """
    count = len(track.turns)
    first, last = 0, count - 1
    if not track.loops:
        first = int(np.clip((begin - 2 * SPREAD_SMOOTHING_TIME) * track.rate, 0, count - 1))
        last = int(np.clip(np.ceil((end + 2 * SPREAD_SMOOTHING_TIME) * track.rate), first, count - 1))
    search = _Search.of(body, covered)
    stride = max(1, int(track.rate / SPREAD_SAMPLE_RATE))
    looked = np.unique(np.append(np.arange(first, last + 1, stride), last))
    found = np.zeros((len(looked), len(LIMB_GROUPS)))
    for row, index in enumerate(looked):
        found[row] = search.least(Pose(track.turns[index], track.pelvis[index]))
    poses = np.arange(first, last + 1)
    required = np.stack([np.interp(poses, looked, column) for column in found.T], axis=1)
    angles, missed = np.zeros((count, len(LIMB_GROUPS))), np.zeros((count, len(LIMB_GROUPS)), dtype=bool)
    angles[poses] = _smooth(np.minimum(required, MAX_LIMB_SPREAD_ANGLE), track, stride)
    missed[poses] = required > MAX_LIMB_SPREAD_ANGLE + SPREAD_ANGLE_TOLERANCE
    turns, pelvis = track.turns.copy(), track.pelvis.copy()
    for index in np.flatnonzero(angles.any(axis=1)):
        pose = spread_limbs(Pose(turns[index], pelvis[index]), body.rest_joints, angles[index])
        turns[index], pelvis[index] = pose.turns, pose.pelvis
    return ClearedMotion(replace(track, turns=turns, pelvis=pelvis), angles, missed)


def spread_limbs(pose: Pose, rest_joints: np.ndarray, angles: np.ndarray) -> Pose:
    """Return a pose with the limbs of `LIMB_GROUPS` turned outward by angles [rad], shape [3].

    Args:
        pose: The pose.
        rest_joints: Joints in the T-pose [m], shape [24, 3].
        angles: One for each of `LIMB_GROUPS`.
    """
    transforms = pose.transforms(rest_joints)
    world, joints = articulate(pose.turns, rest_joints, pose.pelvis - rest_joints[0])
    world, feet = np.array(world), [JOINTS.index(f"{side}_{name}") for side in ("left", "right") for name in _FOOT]
    for limbs, angle in zip(LIMB_GROUPS.values(), angles, strict=True):
        for limb in limbs:
            turn = Rotation.from_rotvec(angle * limb.axis(transforms, joints)).as_matrix()
            moved = [joint for joint in limb.joints if joint not in feet]
            world[moved] = turn @ world[moved]
    turns = np.stack([world[j] if p < 0 else world[p].T @ world[j] for j, p in enumerate(JOINT_PARENTS)])
    later = articulate(turns, rest_joints, pose.pelvis - rest_joints[0])[1]
    raised = float(later[feet, 1].min() - joints[feet, 1].min())
    return Pose(turns, pose.pelvis - [0.0, raised, 0.0])


_FOOT = ("ankle", "foot")


@dataclass(frozen=True)
class _Search:
    """Describe the wearer for the search of the least angles: faces of each limb, and of the skin that it may meet."""

    mover: MovingBody
    gaps: LimbGaps
    covered: np.ndarray
    parts: tuple[tuple[np.ndarray, np.ndarray], ...]

    @classmethod
    def of(cls, body: Body, covered: np.ndarray) -> _Search:
        gaps = LimbGaps(body)
        left, right, hip, other = (
            gaps.share((limb,))[body.faces].mean(axis=1) for limbs in LIMB_GROUPS.values() for limb in limbs
        )
        trunk = np.flatnonzero(left + right <= 0.5)
        parts = (
            (np.flatnonzero(left > 0.5), trunk),
            (np.flatnonzero(right > 0.5), trunk),
            (
                np.flatnonzero(hip > MIN_LEG_WEIGHT_SHARE),
                np.flatnonzero((other > MIN_LEG_WEIGHT_SHARE) & (hip <= MIN_LEG_WEIGHT_SHARE)),
            ),
        )
        return cls(MovingBody(body), gaps, covered, parts)

    def least(self, pose: Pose) -> np.ndarray:
        """Return the least angle of each group that clears it [rad], shape [3], up to twice `MAX_LIMB_SPREAD_ANGLE`."""
        angles = np.zeros(len(LIMB_GROUPS))
        for turn in range(MAX_SPREAD_ITERATIONS):
            joints = self.mover.body.rest_joints
            body = self.mover.posed(spread_limbs(pose, joints, angles) if angles.any() else pose)
            more = np.array([self._need(body, *each) for each in zip(LIMB_GROUPS.values(), self.parts, strict=True)])
            changed = np.clip(angles + more, 0.0, 2 * MAX_LIMB_SPREAD_ANGLE)
            is_settled = np.abs(changed - angles).max() < SPREAD_ANGLE_TOLERANCE
            angles = changed
            if is_settled or (turn == 0 and not angles.any()):
                break
        return angles

    def _need(self, body: Body, limbs: tuple[Limb, ...], part: tuple[np.ndarray, np.ndarray]) -> float:
        """Return the missing spread of a group [rad]; negative where it is spread further than needed."""
        found = self.gaps.measure(body, limbs, *part)
        wide = found.widening > MIN_GAP_WIDENING
        if not wide.any():
            return -float(MAX_LIMB_SPREAD_ANGLE)
        room = CLOTH_LAYER_CLEARANCE * self.covered[found.ends[wide]].any(axis=2).sum(axis=1)
        return float(((room - found.width[wide]) / found.widening[wide]).max())


def _smooth(required: np.ndarray, track: Track, stride: int) -> np.ndarray:
    """Return angles that change smoothly and are nowhere less than those wanted [rad], [n, k]."""
    from scipy.ndimage import convolve1d, maximum_filter1d

    half = max(int(np.ceil(SPREAD_SMOOTHING_TIME * track.rate)), stride)
    window = np.hanning(2 * half + 3)[1:-1]
    mode = "wrap" if track.loops and len(required) > 1 else "nearest"
    inner = required[:-1] if mode == "wrap" else required
    widened = maximum_filter1d(inner, 2 * half + 1, axis=0, mode=mode)
    smooth = convolve1d(widened, window / window.sum(), axis=0, mode=mode)
    return np.concatenate([smooth, smooth[:1]]) if mode == "wrap" else smooth
