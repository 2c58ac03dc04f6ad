"""The 26 measures of a body, with the lines along which each is taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..run.units import MM_PER_M
from .body import Body
from .body_landmarks import ACROSS_JOINT, Landmarks, find_landmarks
from .measure_names import HOW_MEASURED, MEASURE_KINDS, Quantity
from .standing import StandingBody, cut_faces, girth_of, length_of_line, stand, taut_path

WEARER_METRICS = "wearer."
"""Beginning of the names of metrics that are a wearer's measures."""

WRIST_REACH = 0.01
"""Distance from the wrist's joint along the forearm within which the wrist is thinnest [m]."""

AHEAD_OF_JOINTS = np.array([0.026, 0.004])
"""Distances of the side's upright line ahead of the joints of hip and shoulder [m], on the bodies of `WAIST_SHARE`."""

UPRIGHT_OFFSET = 0.08
"""Distance beside the body at which the lines of upright distances are drawn [m]."""

WRIST_LEVEL_COUNT = 7
"""Number of cuts among which the thinnest of a wrist is chosen."""


@dataclass(frozen=True)
class BodyMeasure:
    """Describe one measure of a body.

    Attributes:
        name: One of `HOW_MEASURED`.
        value: Its length [m] or angle [rad]; NaN where the mesh is open there.
        lines: Where it is taken, on the standing body [m], shape [n, 3] each.
    """

    name: str
    value: float
    lines: tuple[np.ndarray, ...]

    @property
    def is_angle(self) -> bool:
        """Return whether it is an angle."""
        return MEASURE_KINDS[self.name].quantity == Quantity.ANGLE

    @property
    def how(self) -> str:
        """Return how it is taken."""
        return HOW_MEASURED[self.name]


@dataclass(frozen=True)
class MeasuredFigure:
    """Describe the measures of a body, and the body as it stood for them."""

    standing: StandingBody
    measures: tuple[BodyMeasure, ...]

    def value(self, name: str) -> float:
        """Return a measure by name [m or rad]."""
        return next(one.value for one in self.measures if one.name == name)


def measure_body(body: Body) -> MeasuredFigure:
    """Take the 26 measures of a body, in the order of `HOW_MEASURED`.

    A given mesh is measured as it stands, if it stands upright with its arms away from the trunk; other bodies by their
    fitted model with its arms at 45 degrees, so that the pose does not matter.

    Args:
        body: The body.
    """
    standing = stand(body)
    at = find_landmarks(standing)
    girths = {
        name: girth_of(standing.level(height), 1)
        for name, height in (("bust", at.bust), ("underbust", at.underbust), ("waist", at.waist), ("hip", at.hip))
    }
    found = _heights(standing, at) | _lengths(standing, at) | {
        name: (value, (line,)) for name, (value, line) in girths.items()
    }  # fmt: skip
    for name, girth in (("back_width", "bust"), ("waist_back_width", "waist"), ("hip_back_width", "hip")):
        line = _back_of(girths[girth][1], _side_depth(standing, girths[girth][1]))
        found[name] = length_of_line(line), (line,)
    legs, _ = standing.legs(at.thigh)
    thigh = max((girth_of(points, 1) for points in legs), key=lambda one: np.nan_to_num(one[0]))
    found["thigh"] = thigh[0], (thigh[1],)
    found["wrist"] = _wrist(standing)
    lines = found["arm_length"][1]
    found["arm_angle"] = float(np.mean([_slope(line[0], line[1]) for line in lines])), lines
    return MeasuredFigure(standing, tuple(BodyMeasure(name, *found[name]) for name in HOW_MEASURED))


def tabulate_body(body: Body) -> dict[str, float | None]:
    """Return the measures of a body as metrics, `wearer.waist_mm` or `wearer.shoulder_slope_deg`: None where the mesh
    is open there, nothing of a dress form."""
    if body.is_dress_form:
        return {}
    found: dict[str, float | None] = {}
    for one in measure_body(body).measures:
        name, scale = (f"{one.name}_deg", np.degrees(1.0)) if one.is_angle else (f"{one.name}_mm", MM_PER_M)
        found[f"{WEARER_METRICS}{name}"] = float(scale * one.value) if np.isfinite(one.value) else None
    return found


Taken = dict[str, tuple[float, tuple[np.ndarray, ...]]]


def _heights(body: StandingBody, at: Landmarks) -> Taken:
    """Return the measures that are upright distances or angles."""
    side = 0.5 * (_width(body, at.hip) - _width(body, at.waist))
    beside = _width(body, at.hip) / 2.0 + UPRIGHT_OFFSET

    def upright(top: float, bottom: float, out: float = 0.0) -> tuple[float, tuple[np.ndarray, ...]]:
        return top - bottom, (np.array([[beside + out, top, 0.0], [beside + out, bottom, 0.0]]),)

    slopes = [_slope(neck, shoulder) for neck, shoulder in zip(at.necks, at.shoulders, strict=True)]
    lines = tuple(np.stack(pair) for pair in zip(at.necks, at.shoulders, strict=True))
    half = [_width(body, height) / 2.0 for height in (at.hip, at.waist)]
    return {
        "height": upright(at.crown, 0.0, UPRIGHT_OFFSET),
        "head_length": upright(at.crown, float(at.nape[1])),
        "bust_level": upright(float(at.nape[1]), at.bust),
        "waist_to_hip": upright(at.waist, at.hip),
        "hip_to_crotch": upright(at.hip, at.crotch),
        "hip_slope": (
            float(np.arctan2(side, at.waist - at.hip)),
            (np.array([[half[0], at.hip, 0.0], [half[1], at.waist, 0.0]]),),
        ),
        "shoulder_slope": (float(np.mean(slopes)), lines),
    }


def _lengths(body: StandingBody, at: Landmarks) -> Taken:
    """Return the measures that are straight or taut distances between landmarks."""
    found: Taken = {
        "shoulder_width": _straight(at.shoulders),
        "bust_span": _straight(at.bust_points),
        "seat_span": _straight(at.seat_points),
        "neck_width": _neck(body, at),
    }
    for name, ends in (("armscye_depth", at.armpits), ("arm_length", at.wrists)):
        lines = tuple(np.stack(pair) for pair in zip(at.shoulders, ends, strict=True))
        found[name] = float(np.mean([length_of_line(line) for line in lines])), lines
    middle = float(at.nape[0])
    found["back_waist_length"] = _down(body, at.nape, at.waist, middle, -1.0)
    fronts, depths = [], []
    for neck, shoulder, point in zip(at.necks, at.shoulders, at.bust_points, strict=True):
        share = np.clip((point[0] - neck[0]) / (shoulder[0] - neck[0]), 0.0, 1.0)
        start = _on_ridge(body, float(point[0]), neck + share * (shoulder - neck))
        fronts.append(_down(body, start, at.waist, float(point[0]), 1.0))
        depths.append(_down(body, start, at.bust, float(point[0]), 1.0))
    for name, both in (("front_waist_length", fronts), ("bust_depth", depths)):
        found[name] = float(np.mean([one[0] for one in both])), tuple(line for one in both for line in one[1])
    return found


def _straight(ends: np.ndarray) -> tuple[float, tuple[np.ndarray, ...]]:
    return length_of_line(ends), (ends,)


def _down(
    body: StandingBody, start: np.ndarray, low: float, x: float, forward: float
) -> tuple[float, tuple[np.ndarray, ...]]:
    """Return the tape from a start down the front (forward 1) or the back (-1) to a height [m], pulled taut."""
    points, _ = cut_faces(body.vertices, body.trunk_faces, np.array([1.0, 0.0, 0.0]), x)
    between = points[(points[:, 1] < start[1]) & (points[:, 1] > low)]
    if not len(between):
        return float("nan"), ()
    near = between[between[:, 1] < low + ACROSS_JOINT]
    near = near if len(near) else between
    end = np.array([x, low, near[(forward * near[:, 2]).argmax(), 2]])
    begin = np.array([x, start[1], start[2]])
    line = taut_path(between, begin, end, np.array([0.0, 0.0, forward]))
    return length_of_line(line), (line,)


def _on_ridge(body: StandingBody, x: float, near: np.ndarray) -> np.ndarray:
    """Return the skin of the shoulder at x above the line from the neck's to the shoulder's joint [m], shape [3]."""
    points, _ = cut_faces(body.vertices, body.faces, np.array([1.0, 0.0, 0.0]), x)
    depth = np.interp(abs(x), *np.abs([[0.0, body.joint("left_shoulder")[0]], [1.0, 0.0]]))
    middle = depth * body.joint("neck")[2] + (1.0 - depth) * body.joint("left_shoulder")[2]
    own = points[(np.abs(points[:, 1] - near[1]) < ACROSS_JOINT * 3.0) & (np.abs(points[:, 2] - middle) < ACROSS_JOINT)]
    found: np.ndarray = own[np.abs(own[:, 2] - middle).argmin()] if len(own) else near
    return found


def _neck(body: StandingBody, at: Landmarks) -> tuple[float, tuple[np.ndarray, ...]]:
    """Return the tape behind the neck through the side neck points and the nape."""
    normal = np.cross(at.necks[0] - at.nape, at.necks[1] - at.nape)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-12)
    points, _ = cut_faces(body.vertices, body.trunk_faces, normal, float(normal @ at.nape))
    behind = points[(points[:, 2] < at.necks[:, 2].mean()) & (np.abs(points[:, 0]) < np.abs(at.necks[:, 0]).max())]
    line = taut_path(behind, at.necks[1], at.necks[0], np.array([0.0, 0.0, -1.0]))
    return length_of_line(line), (line,)


def _side_depth(body: StandingBody, line: np.ndarray) -> float:
    """Return the depth of the side's upright line at a girth [m]: it runs from ahead of the hip's joint to ahead of the
    shoulder's."""
    hip, shoulder = (np.mean([body.joint(f"{s}_{j}") for s in ("left", "right")], axis=0) for j in ("hip", "shoulder"))
    ahead = AHEAD_OF_JOINTS + np.array([hip[2], shoulder[2]])
    height = float(line[0, 1]) if len(line) else float(hip[1])
    return float(np.interp(height, [hip[1], shoulder[1]], ahead))


def _back_of(line: np.ndarray, depth: float) -> np.ndarray:
    """Return the part of a girth's closed line behind a depth [m], shape [n, 3], from one side to the other."""
    if not len(line):
        return line
    start, end = line[:-1], line[1:]
    behind = start[:, 2] < depth
    leaves = int(np.flatnonzero(behind & (end[:, 2] >= depth))[0]) if behind.any() and not behind.all() else 0
    ring = np.roll(line[:-1], -leaves - 1, axis=0)[::-1]  # from the last point behind, backwards
    own = ring[: int(np.argmax(ring[:, 2] >= depth))] if (ring[:, 2] >= depth).any() else ring
    first, last = _at_depth(ring[-1], ring[0], depth), _at_depth(ring[len(own) % len(ring)], own[-1], depth)
    return np.concatenate([first[None], own, last[None]])


def _at_depth(ahead: np.ndarray, behind: np.ndarray, depth: float) -> np.ndarray:
    """Return the point between two at a depth [m], shape [3]."""
    share = (depth - behind[2]) / (ahead[2] - behind[2]) if ahead[2] != behind[2] else 0.0
    return np.asarray(behind + np.clip(share, 0.0, 1.0) * (ahead - behind))


def _width(body: StandingBody, height: float) -> float:
    points = body.level(height)
    return float(np.ptp(points[:, 0])) if len(points) else float("nan")


def _slope(neck: np.ndarray, shoulder: np.ndarray) -> float:
    """Return the angle of the way between two points below level [rad]."""
    return float(np.arctan2(neck[1] - shoulder[1], np.linalg.norm((shoulder - neck)[[0, 2]])))


def _wrist(body: StandingBody) -> tuple[float, tuple[np.ndarray, ...]]:
    """Return the mean of both wrists where they are thinnest, square to the forearm."""
    found = []
    for side in ("left", "right"):
        joint, elbow = body.joint(f"{side}_wrist"), body.joint(f"{side}_elbow")
        axis = (joint - elbow) / np.linalg.norm(joint - elbow)
        first = np.cross(axis, [0.0, 0.0, 1.0])
        first /= np.linalg.norm(first)
        frame = np.stack([axis, first, np.cross(axis, first)])
        own = body.faces[body.is_arm[body.faces].any(axis=1)]
        own = own[(np.linalg.norm(body.vertices[own].mean(axis=1) - joint, axis=1) < 0.15)]
        girths = []
        for shift in np.linspace(-WRIST_REACH, WRIST_REACH, WRIST_LEVEL_COUNT):
            points, _ = cut_faces(body.vertices, own, axis, float(axis @ joint + shift))
            value, line = girth_of(points @ frame.T, 0)
            girths.append((value, line @ frame))
        found.append(min(girths, key=lambda one: np.nan_to_num(one[0], nan=np.inf)))
    return float(np.mean([one[0] for one in found])), tuple(one[1] for one in found)
