"""Find the up axis and the unit of a person's scan from the distribution of a body's surface over its height.

A slice at some height has a share of the surface and a spread about the person's axis; both show where the head is, in
any unit and heading. They are compared with the built-in body's in many poses, for each of the six axes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..body.body import JOINTS
from ..body.skinning import skin
from ..body.template import articulate, load_template, rotations_of, transforms_of
from ..geometry.geometry import vertex_areas
from ..run.units import METRIC, UNITS
from .refusal import UnitsUnknown
from .units import BODY_LONGEST

AXES_UP = ("y", "z", "-y", "-z", "x", "-x")
"""Axes of the file that may point up, the usual ones first."""
NORMALISED_SIZES = (1.0, 2.0)
"""Longest sides of a file whose content was scaled into a box from 0 to 1, or from -1 to 1, and has no unit [1]."""
NORMALISED_SIZE_TOLERANCE = 1e-3
"""Largest deviation from `NORMALISED_SIZES` [1]: of float32 and of text with four digits."""
DEFAULT_STATURE = 1.70
"""Height assumed for a person whose unit is none of `UNITS` [m]: between the means of women and men."""
MAX_PERSON_MISFIT = 0.7
"""Largest misfit of a person [1] in any unit: dressed people have up to 0.5, a box as tall or half a person more."""
PERSON_PART_SIZE_RANGE = (0.3, 5.0)
"""Least and largest size of what may be a part of a person, or several [m]."""
PROFILE_SLICE_COUNT = 24
"""Number of slices over the height: each is 7 cm of an adult, less than a head, a thigh or an upper arm is long."""
PROFILE_TAIL_SHARE = 0.002
"""Share of the points that may be beyond either end of the height: flyers, a strand of hair."""
UNUSUAL_AXIS_PENALTY = 1.25
"""Factor on the misfit of all axes but the usual ones (y, z), which few files have. A person in a T-pose lying on the
side matches at least 2 times worse than upright."""
MIN_AXIS_MISFIT_RATIO = 1.3
"""Ratio of the second best axis' misfit to that of the best above which the best is certain."""
POSES: dict[str, dict[str, tuple[float, float, float]]] = {
    "T": {},
    "A": {"left_shoulder": (0, 0, -0.8), "right_shoulder": (0, 0, 0.8)},
    "arms down": {"left_shoulder": (0, 0, -1.25), "right_shoulder": (0, 0, 1.25)},
    "arms up": {
        "left_collar": (0, 0, 0.3), "right_collar": (0, 0, -0.3),
        "left_shoulder": (0, 0, 1.1), "right_shoulder": (0, 0, -1.1),
    },
    "goalpost": {"left_elbow": (0, 0, 1.5), "right_elbow": (0, 0, -1.5)},
    "one arm up": {
        "left_collar": (0, 0, 0.3), "left_shoulder": (0, 0, 1.1), "right_shoulder": (0, 0, 1.25),
    },
    "on hips": {
        "left_shoulder": (0, 0, -0.9), "right_shoulder": (0, 0, 0.9), "left_elbow": (0, 0, -1.6),
        "right_elbow": (0, 0, 1.6),
    },
    "arms forward": {"left_shoulder": (0, -1.4, 0), "right_shoulder": (0, 1.4, 0)},
    "stride": {
        "left_hip": (-0.6, 0, 0), "right_hip": (0.5, 0, 0), "right_knee": (0.4, 0, 0),
        "left_shoulder": (0, 0, -1.0), "right_shoulder": (0, 0, 1.0),
    },
    "legs apart": {
        "left_hip": (0, 0, 0.4), "right_hip": (0, 0, -0.4), "left_shoulder": (0, 0, -0.8),
        "right_shoulder": (0, 0, 0.8),
    },
    "seated": {
        "left_hip": (-1.4, 0, 0.1), "right_hip": (-1.4, 0, -0.1), "left_knee": (1.4, 0, 0), "right_knee": (1.4, 0, 0),
        "left_shoulder": (0, -0.3, -1.0), "right_shoulder": (0, 0.3, 1.0), "left_elbow": (0, -0.6, 0),
        "right_elbow": (0, 0.6, 0),
    },
}  # fmt: skip
"""Poses that a scan is compared with, as axis-angles [rad] of the joints that differ from the T-pose."""

LEG_JOINTS = (
    "left_hip",
    "right_hip",
    "left_knee",
    "right_knee",
    "left_ankle",
    "right_ankle",
    "left_foot",
    "right_foot",
)
"""Joints whose skin a skirt covers."""
SKIRT_HEM_SHARES = ((0.02, 0.24), (0.02, 0.15), (0.28, 0.16))
"""Shares of the stature that are height and radius of the hem of each skirt that a scan is compared with: a gown, a
long dress, one to the knee. Without them a gown is more like a person head down with arms spread."""
SKIRT_POSES = ("T", "A", "arms down", "on hips")
"""Poses of `POSES` that are combined with each of `SKIRT_HEM_SHARES`."""
SKIRT_WAIST_SHARES = (0.62, 0.08)
"""Shares of the stature that are height and radius of a skirt's upper end."""


@dataclass(frozen=True)
class Profile:
    """Describe the distribution of a person's surface over the height.

    Attributes:
        share: Share of the surface in each slice from the lowest on, sum 1, shape [PROFILE_SLICE_COUNT].
        spread: RMS distance of each slice from the central vertical, in heights, shape [PROFILE_SLICE_COUNT].
        height: From the lowest to the highest point, in the unit of the points.
        ratio: Height of the standing person over `height`; 1 where not known.
    """

    share: np.ndarray
    spread: np.ndarray
    height: float
    ratio: float = 1.0


@dataclass(frozen=True)
class UprightAxis:
    """Describe the up axis of a file.

    Attributes:
        up: One of `AXES_UP`.
        misfit: Difference from the most similar pose; below 0.5 for people, also dressed ones.
        others: Misfit of each axis, by its name.
        ratio: Standing height over the height measured along the axis, by that pose.
        is_sure: Whether the misfit of all other axes is clearly larger.
    """

    up: str
    misfit: float
    others: dict[str, float]
    ratio: float
    is_sure: bool


def turn_upright(points: np.ndarray, up: str) -> np.ndarray:
    """Turn positions or directions, shape [n, 3], so that the file's axis `up` becomes y; a rotation about x or z."""
    x, y, z = np.asarray(points).T
    turned = {
        "y": (x, y, z), "z": (x, z, -y), "-y": (x, -y, -z), "-z": (x, -z, y), "x": (-y, x, z), "-x": (y, -x, z),
    }[up]  # fmt: skip
    return np.stack(turned, axis=1)


def measure_profile(points: np.ndarray, weights: np.ndarray | None = None) -> Profile:
    """Measure the distribution over y of points, shape [n, 3], uniform over a surface or weighted by their areas."""
    weights = np.ones(len(points)) if weights is None else weights
    order = np.argsort(points[:, 1], kind="stable")
    passed = np.cumsum(weights[order]) / weights.sum()
    ends = np.minimum(np.searchsorted(passed, np.array([PROFILE_TAIL_SHARE, 1.0 - PROFILE_TAIL_SHARE])), len(order) - 1)
    low, high = (float(value) for value in points[order[ends], 1])
    height = max(high - low, 1e-12)
    place = np.clip(((points[:, 1] - low) / height * PROFILE_SLICE_COUNT).astype(np.int64), 0, PROFILE_SLICE_COUNT - 1)
    flat = points[:, [0, 2]]
    centre = (flat * weights[:, None]).sum(axis=0) / weights.sum()
    distance = np.minimum(np.sqrt(((flat - centre) ** 2).sum(axis=1)) / height, 1.0)
    share = np.bincount(place, weights, PROFILE_SLICE_COUNT)
    spread = np.sqrt(np.bincount(place, weights * distance**2, PROFILE_SLICE_COUNT) / np.maximum(share, 1e-12))
    return Profile(share / share.sum(), spread, height)


def build_profiles() -> list[Profile]:
    """Build the profiles of the built-in body, both mean shapes, in every pose of `POSES`, some with skirts."""
    template = load_template()
    found = []
    for mean in template.means.values():
        rest, joints = template.shaped(mean)
        areas = vertex_areas(rest, template.faces)
        stature = float(np.ptp(rest[:, 1]))
        legs = template.weights[:, [JOINTS.index(name) for name in LEG_JOINTS]].sum(axis=1) > 0.5
        for name, pose in POSES.items():
            vectors = np.zeros((24, 3))
            for joint, vector in pose.items():
                vectors[JOINTS.index(joint)] = vector
            world, posed = articulate(rotations_of(vectors), joints, np.zeros(3))
            points = skin(rest, template.weights, transforms_of(world, posed, joints))
            found.append(_measure(points, areas, stature))
            for hem, radius in SKIRT_HEM_SHARES if name in SKIRT_POSES else ():
                low = points[:, 1].min() + hem * stature
                cone, skirt = _build_skirt(points[legs, 1].min(), hem, radius, stature)
                bare = np.where(legs & (points[:, 1] > low), 0.0, areas)
                found.append(_measure(np.concatenate([points, cone]), np.r_[bare, skirt], stature))
    return found


def _measure(points: np.ndarray, areas: np.ndarray, stature: float) -> Profile:
    profile = measure_profile(points, areas)
    return replace(profile, ratio=stature / profile.height)


def _build_skirt(floor: float, hem: float, radius: float, stature: float) -> tuple[np.ndarray, np.ndarray]:
    """Build points on a cone from the waist to the hem around the y axis, and their areas."""
    share = (np.arange(40) + 0.5) / 40
    height = floor + stature * (hem + share * (SKIRT_WAIST_SHARES[0] - hem))
    wide = stature * (radius + share * (SKIRT_WAIST_SHARES[1] - radius))
    angle = 2.0 * np.pi * np.arange(16) / 16
    points = np.stack(
        [np.outer(wide, np.cos(angle)), np.repeat(height[:, None], 16, axis=1), np.outer(wide, np.sin(angle))], axis=2
    )
    slant = float(np.hypot(SKIRT_WAIST_SHARES[0] - hem, radius - SKIRT_WAIST_SHARES[1])) * stature
    return points.reshape(-1, 3), np.repeat(2.0 * np.pi * wide * slant / 640, 16)


def compare_profiles(first: Profile, second: Profile) -> float:
    """Return the difference of two profiles: of running sums of shares (the earth mover's distance), and of spreads.

    A belly or a hem that is a slice higher is a small difference.
    """
    moved = float(np.abs(np.cumsum(first.share) - np.cumsum(second.share)).mean())
    spread = float((0.5 * (first.share + second.share) * np.abs(first.spread - second.spread)).sum())
    return 10.0 * (moved + spread)


def find_upright(
    points: np.ndarray, profiles: list[Profile] | None = None, axes: tuple[str, ...] = AXES_UP
) -> UprightAxis:
    """Find the axis that points up from points uniform over a person's surface, shape [n, 3], any unit and heading."""
    profiles = build_profiles() if profiles is None else profiles
    found: dict[str, tuple[float, float]] = {}
    for axis in axes:
        profile = measure_profile(turn_upright(points, axis))
        found[axis] = min((compare_profiles(profile, other), other.ratio) for other in profiles)
    weighed = {axis: value[0] * (1.0 if axis in ("y", "z") else UNUSUAL_AXIS_PENALTY) for axis, value in found.items()}
    best = min(axes, key=lambda axis: weighed[axis])
    rest = min((value for axis, value in weighed.items() if axis != best), default=np.inf)
    return UprightAxis(
        best, found[best][0], {axis: value[0] for axis, value in found.items()}, found[best][1],
        rest > MIN_AXIS_MISFIT_RATIO * weighed[best],
    )  # fmt: skip


def is_normalised(size: float) -> bool:
    """Return whether the longest side of a file's content [unit] is that of one that was scaled into a box."""
    return any(abs(size / normal - 1.0) < NORMALISED_SIZE_TOLERANCE for normal in NORMALISED_SIZES)


def find_length_unit(height: float, found: UprightAxis, is_unitless: bool = False) -> tuple[str, float]:
    """Find the unit in which a height [unit] is a person's; return its name and metres in one.

    Args:
        height: From the lowest to the highest point.
        found: The up axis.
        is_unitless: Whether the file is known to have no unit.

    Returns:
        A name of `UNITS`. Where none fits, `unknown` with the scale that makes the person `DEFAULT_STATURE` high, or
        for what is less like a person the unit of `METRIC` in which its size is in `PERSON_PART_SIZE_RANGE`.

    Raises:
        UnitsUnknown: where none of these fits.
    """
    for name, metres in () if is_unitless else UNITS.items():  # at most one fits
        if BODY_LONGEST[0] <= height * metres <= BODY_LONGEST[1]:
            return name, metres
    if found.is_sure and found.misfit < MAX_PERSON_MISFIT:
        return "unknown", DEFAULT_STATURE / (height * found.ratio)
    for name in METRIC:
        if PERSON_PART_SIZE_RANGE[0] <= height * UNITS[name] <= PERSON_PART_SIZE_RANGE[1]:
            return name, UNITS[name]
    raise UnitsUnknown(
        f"What is in the scan measures {height:.3g}, no person's height in any unit; say its unit with --units."
    )
