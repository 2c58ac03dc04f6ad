"""Places on a standing body between which it is measured, as ISO 8559-1 defines them, by its joints and its skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .standing import StandingBody, cut_faces, girth_of

WAIST_SHARE = 0.341
"""Share of the way from the pelvis' joint to the neck's at which the waist is: the middle between ribs and hip bones,
on the mean bodies of GarmentMeasurements (S. Bothe, M. Botsch), of both genders."""

WAIST_REACH = 0.02
"""Distance from there within which the waist is the narrowest place [m]."""

UNDERBUST_SHARE = 0.575
"""Share of the way from the waist to the bust points at which the underbust is, on the same bodies."""

THIGH_SHARE = 0.285
"""Share of the way from hip to knee joint at which a thigh is measured, on the same bodies; where the legs are still
joined there, at `BELOW_FORK_OF_LEGS`."""

BELOW_FORK_OF_LEGS = 0.005
"""Distance of the thigh's girth below the crotch where its usual place is higher [m]."""

TAPE_WIDTH = 0.0127
"""Width of a tailor's tape [m], half an inch: over the bust points the largest girth that it covers counts."""

HIP_REACH = 0.02
"""Distance from the seat points within which the hip is the widest place [m]."""

MEASURED_LEVEL_SPACING = 0.0025
"""Distance of the levels among which one is chosen [m]: a quarter of the vertices' spacing, a tape's graduation."""

CROTCH_SHARE = 0.27
"""Share of the way from hip to knee joint at which the crotch is of legs that touch, on the same bodies."""

BUST_DROPS = (0.02, 0.11)
"""Range below the armpits in which the bust points are sought [m]: on the same bodies they are 5 to 6 cm below."""

USUAL_BUST_DROP = 0.053
"""Distance of the bust points below the armpits of a chest without any [m], the mean of the same bodies."""

BUST_X = (0.03, 0.16)
"""Range of distances from the median plane in which a bust or seat point is sought [m]."""

BEYOND_SHOULDER_JOINT = 0.004
"""Distance of the end of the shoulder outside of its joint [m], on the same bodies."""

NECK_ROUNDING = 0.01
"""Distance outward from the deepest point between neck and shoulder to the side neck point [m]: half of what is round
there, on the same bodies."""

OUTWARD_ANGLE = np.radians(10.0)
"""Angle by which bust and seat points face outward [rad]."""

ACROSS_JOINT = 0.015
"""Distance from a joint in depth within which the skin above and below it is sought [m]: a fingertip."""

WRIST_RADIUS = 0.06
"""Distance from the joint within which skin is the wrist's [m]."""


@dataclass(frozen=True)
class Landmarks:
    """Describe places on a standing body [m].

    Attributes:
        nape: The skin behind the neck's joint, shape [3].
        necks: Where neck and shoulder meet, left and right, shape [2, 3].
        shoulders: The skin above the shoulders' joints, left and right, shape [2, 3].
        armpits: The skin below these, shape [2, 3].
        bust_points, seat_points: The most prominent points of chest and seat, shape [2, 3] each.
        wrists: The skin over the wrists' joints, shape [2, 3].
        crown: Height of the highest point.
        bust, underbust, waist, hip, thigh, crotch: Heights at which girths are taken, and of the crotch.
    """

    nape: np.ndarray
    necks: np.ndarray
    shoulders: np.ndarray
    armpits: np.ndarray
    bust_points: np.ndarray
    seat_points: np.ndarray
    wrists: np.ndarray
    crown: float
    bust: float
    underbust: float
    waist: float
    hip: float
    thigh: float
    crotch: float


def find_landmarks(body: StandingBody) -> Landmarks:
    """Find the landmarks of a standing body."""
    pelvis, neck = body.joint("pelvis"), body.joint("neck")
    shoulders, armpits = (np.stack([_shoulder(body, side)[i] for side in ("left", "right")]) for i in (0, 1))
    usual = float(pelvis[1] + WAIST_SHARE * (neck[1] - pelvis[1]))
    waist = _best_level(body, usual, WAIST_REACH, least=True)
    bust_points = _bust_points(body, float(armpits[:, 1].mean()), waist)
    crotch = _crotch(body)
    seat_points = _seat_points(body, crotch)
    hip_joints, knees = (np.mean([body.joint(f"{s}_{j}")[1] for s in ("left", "right")]) for j in ("hip", "knee"))
    at_bust = float(bust_points[:, 1].mean())
    return Landmarks(
        nape=_behind_neck(body),
        necks=np.stack(
            [_side_neck(body, sign, shoulder) for sign, shoulder in zip((1.0, -1.0), shoulders, strict=True)]
        ),
        shoulders=shoulders,
        armpits=armpits,
        bust_points=bust_points,
        seat_points=seat_points,
        wrists=np.stack([_over_wrist(body, side) for side in ("left", "right")]),
        crown=float(body.vertices[:, 1].max()),
        bust=_best_level(body, at_bust, TAPE_WIDTH / 2.0, least=False),
        underbust=usual + UNDERBUST_SHARE * (at_bust - usual),
        waist=waist,
        hip=_best_level(body, float(seat_points[:, 1].mean()), HIP_REACH, least=False),
        thigh=float(min(hip_joints - THIGH_SHARE * (hip_joints - knees), crotch - BELOW_FORK_OF_LEGS)),
        crotch=crotch,
    )


def _best_level(body: StandingBody, middle: float, reach: float, least: bool) -> float:
    """Return the level of the least or the largest girth of the trunk within reach of a height [m]."""
    count = 2 * int(np.ceil(reach / MEASURED_LEVEL_SPACING)) + 1
    levels = np.linspace(middle - reach, middle + reach, count)
    girths = [girth_of(body.level(float(height)), 1)[0] for height in levels]
    if not np.isfinite(girths).any():
        return middle
    return float(levels[int(np.nanargmin(girths) if least else np.nanargmax(girths))])


def _shoulder(body: StandingBody, side: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the skin above and below the joint of a shoulder [m], shape [3] each."""
    joint = body.joint(f"{side}_shoulder")
    joint = joint + [np.sign(joint[0]) * BEYOND_SHOULDER_JOINT, 0.0, 0.0]
    points, _ = cut_faces(body.vertices, body.faces, np.array([1.0, 0.0, 0.0]), float(joint[0]))
    near = points[np.abs(points[:, 2] - joint[2]) < ACROSS_JOINT]
    above, below = near[near[:, 1] > joint[1]], near[near[:, 1] < joint[1]]
    top = above[above[:, 1].argmax()] if len(above) else joint
    below = below[below[:, 1] > below[:, 1].max(initial=-np.inf) - ACROSS_JOINT]
    bottom = below[np.abs(below[:, 2] - joint[2]).argmin()] if len(below) else joint
    return top, bottom


def _over_wrist(body: StandingBody, side: str) -> np.ndarray:
    """Return the skin above the joint of a wrist, square to the forearm [m], shape [3]."""
    joint, elbow = body.joint(f"{side}_wrist"), body.joint(f"{side}_elbow")
    axis = (joint - elbow) / np.linalg.norm(joint - elbow)
    upward = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
    own = body.faces[body.is_arm[body.faces].any(axis=1)]
    points, _ = cut_faces(body.vertices, own, axis, float(axis @ joint))
    near = points[np.linalg.norm(points - joint, axis=1) < WRIST_RADIUS]
    found: np.ndarray = near[(near @ upward).argmax()] if len(near) else joint
    return found


def _bust_points(body: StandingBody, armpit: float, waist: float) -> np.ndarray:
    """Return the most prominent points of the chest [m], shape [2, 3]. A chest that recedes all the way up has none:
    then the points at the usual height are taken."""
    lowest = max(armpit - BUST_DROPS[1], min(waist, armpit - USUAL_BUST_DROP))
    heights = np.arange(lowest, armpit - BUST_DROPS[0], MEASURED_LEVEL_SPACING)
    found = []
    for sign in (1.0, -1.0):
        fronts = np.stack([_extreme(body, float(height), sign, 1.0) for height in heights])
        depth = fronts[:, 2]
        inner = np.flatnonzero((depth[1:-1] >= depth[:-2]) & (depth[1:-1] > depth[2:])) + 1
        if len(inner):
            found.append(fronts[inner[depth[inner].argmax()]])
        else:
            found.append(_extreme(body, armpit - USUAL_BUST_DROP, sign, 1.0))
    return np.stack(found)


def _seat_points(body: StandingBody, crotch: float) -> np.ndarray:
    """Return the most prominent points of the seat [m], shape [2, 3], from the crotch to the spine's first joint."""
    heights = np.arange(crotch, max(float(body.joint("spine1")[1]), crotch + HIP_REACH), MEASURED_LEVEL_SPACING)
    found = []
    for sign in (1.0, -1.0):
        backs = np.stack([_extreme(body, float(height), sign, -1.0, 0.0) for height in heights])
        found.append(_extreme(body, float(heights[backs[:, 2].argmin()]), sign, -1.0))
    return np.stack(found)


def _extreme(
    body: StandingBody, height: float, sign: float, forward: float, outward: float = OUTWARD_ANGLE
) -> np.ndarray:
    """Return the foremost (forward 1) or hindmost (-1) point of one side of the trunk at a height [m], shape [3], seen
    from an angle outward [rad]."""
    points = body.level(height)
    off = sign * points[:, 0]
    own = points[(off > BUST_X[0]) & (off < BUST_X[1])]
    if not len(own):
        return np.array([sign * BUST_X[0], height, 0.0])
    away = np.cos(outward) * forward * own[:, 2] + np.sin(outward) * np.abs(own[:, 0])
    found: np.ndarray = own[away.argmax()]
    return found


def _crotch(body: StandingBody) -> float:
    """Return the height up to which the legs are apart [m]: sought from half the thighs to above their joints. Legs
    that touch all the way end in the usual place."""
    hip, knee = (np.mean([body.joint(f"{s}_{j}")[1] for s in ("left", "right")]) for j in ("hip", "knee"))
    heights = np.arange((hip + knee) / 2.0, hip + 0.1 * (hip - knee), MEASURED_LEVEL_SPACING)
    for height in heights:
        if not body.legs(float(height))[1]:
            return float(
                height - MEASURED_LEVEL_SPACING / 2.0 if height > heights[0] else hip - CROTCH_SHARE * (hip - knee)
            )
    return float(heights[-1])


def _behind_neck(body: StandingBody) -> np.ndarray:
    """Return the skin in the median plane at the height of the neck's joint, behind it [m], shape [3]."""
    neck = body.joint("neck")
    points = body.level(float(neck[1]))
    near = points[np.abs(points[:, 0] - neck[0]) < ACROSS_JOINT]
    found: np.ndarray = near[near[:, 2].argmin()] if len(near) else neck
    return np.array([neck[0], neck[1], found[2]])


def _side_neck(body: StandingBody, sign: float, shoulder: np.ndarray) -> np.ndarray:
    """Return where neck and shoulder meet on one side [m], shape [3]: near the deepest point of the ridge below the
    straight line from the neck's side to the end of the shoulder."""
    neck, head = body.joint("neck"), body.joint("head")
    level = body.level(float((neck[1] + head[1]) / 2.0))
    own = level[sign * (level[:, 0] - neck[0]) > 0.0]
    if not len(own):
        return np.asarray(neck)
    start = own[(sign * own[:, 0]).argmax()]
    xs = np.linspace(float(start[0]), float(start[0] + shoulder[0]) / 2.0, 40)[1:-1]
    ridge = []
    for x in xs:
        points, _ = cut_faces(body.vertices, body.faces, np.array([1.0, 0.0, 0.0]), float(x))
        points = points[(points[:, 1] < start[1]) & (points[:, 1] > shoulder[1] - 0.05)]
        if len(points):
            ridge.append(points[points[:, 1].argmax()])
    if not ridge:
        return np.asarray(neck)
    line = np.stack(ridge)
    share = (line[:, 0] - start[0]) / (shoulder[0] - start[0])
    below = start[1] + share * (shoulder[1] - start[1]) - line[:, 1]
    deepest = line[int(below.argmax())]
    found: np.ndarray = line[np.abs(line[:, 0] - deepest[0] - sign * NECK_ROUNDING).argmin()]
    return found
