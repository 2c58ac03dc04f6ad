"""Read motions from BVH files, of whatever skeleton."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ..errors import keep_printable
from .errors import MotionBad, MotionTooLarge
from .keys import RATES
from .recording import MOST_FRAMES, Recording

LARGEST_BYTES = 64 * 1024**2
"""Size of a file at most: twenty minutes of 60 joints at 30 Hz."""

MOST_JOINTS = 512
"""Joints at most; with all fingers and a face there are about 120."""

CHANNELS = {f"{axis}{kind}": (axis, kind) for axis in "XYZ" for kind in ("position", "rotation")}


@dataclass(frozen=True)
class Skeleton:
    """Describe the joints of a BVH file in the file's order.

    Attributes:
        names: As the file has them.
        parents: Index of each joint's parent, -1 for the root.
        offsets: From the parent in the rest pose, in the file's unit, shape [joint_count, 3].
        channels: Names of each joint's channels in their order.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: np.ndarray
    channels: tuple[tuple[str, ...], ...]


def read_bvh(path: Path) -> Recording:
    """Read a motion from a BVH file; `map_skeleton` says which joints are understood.

    Raises:
        MotionBad: where the file is none, with the line that is wrong.
        MotionTooLarge: where it is too large, too long, or has too many joints.
        MotionForeign: where the skeleton is no person's.
    """
    from .skeleton_map import Posed, map_skeleton

    path = Path(path)
    if path.stat().st_size > LARGEST_BYTES:
        raise MotionTooLarge(f"{path.name} is larger than {LARGEST_BYTES >> 20} MB. {MotionTooLarge().message}")
    text = path.read_text(encoding="utf-8", errors="replace")
    skeleton, values, rate = parse_bvh(text, path.name)
    root, turns = pose_skeleton(skeleton, values)
    return map_skeleton(Posed(skeleton.names, skeleton.parents, skeleton.offsets, turns, root), rate)


def pose_skeleton(skeleton: Skeleton, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the root's place in the file's unit, [n, 3], and each joint's rotation in the world, [n, joints, 3, 3].

    A joint's channels are applied in the file's order, the first one outermost: for `Zrotation Xrotation Yrotation`
    R = R_z R_x R_y. Positions of joints other than the root do not count.
    """
    turns = np.zeros((len(values), len(skeleton.names), 3, 3))
    root, at = np.zeros((len(values), 3)), 0
    for joint, (parent, channels) in enumerate(zip(skeleton.parents, skeleton.channels, strict=True)):
        own = values[:, at : at + len(channels)]
        at += len(channels)
        turns[:, joint] = np.eye(3)
        for place, channel in enumerate(channels):
            axis, kind = CHANNELS[channel]
            if kind == "rotation":
                turn = Rotation.from_euler(axis, own[:, place, None], degrees=True).as_matrix()
                turns[:, joint] = turns[:, joint] @ turn
            elif parent < 0:
                root[:, "XYZ".index(axis)] = own[:, place]
        if parent >= 0:
            turns[:, joint] = turns[:, parent] @ turns[:, joint]
    return root, turns


def parse_bvh(text: str, name: str) -> tuple[Skeleton, np.ndarray, float]:
    """Return skeleton, channel values [frame_count, channel_count] and rate [1/s] of a BVH text."""
    head, mark, tail = text.partition("MOTION")
    if not mark or not head.lstrip("\ufeff \t\r\n").startswith("HIERARCHY"):
        raise MotionBad(f"{name}: a BVH file has HIERARCHY, then MOTION. {MotionBad().message}")
    skeleton = _parse_hierarchy(head, name)
    lines = [line.strip() for line in tail.splitlines() if line.strip()]
    frames = _after(lines, 0, "Frames:", name)
    seconds = _after(lines, 1, "Frame Time:", name)
    width = sum(len(channels) for channels in skeleton.channels)
    if frames > MOST_FRAMES:
        raise MotionTooLarge(f"{name}: {frames:g} frames are more than {MOST_FRAMES}. {MotionTooLarge().message}")
    if not frames >= 1 or not RATES[0] <= 1.0 / max(seconds, 1e-9) <= 1000.0:
        raise MotionBad(f"{name}: {frames:g} frames of {seconds:g} s make no motion.")
    try:
        values = np.array(" ".join(lines[2:]).split(), dtype=np.float64)
    except ValueError as error:
        raise MotionBad(f"{name}: the frames hold something that is no number. {MotionBad().message}") from error
    if values.size != int(frames) * width or not np.isfinite(values).all():
        raise MotionBad(f"{name}: {values.size} values for {int(frames)} frames of {width} channels.")
    return skeleton, values.reshape(int(frames), width), 1.0 / seconds


def _parse_hierarchy(text: str, name: str) -> Skeleton:
    """Read ROOT, JOINT, OFFSET, CHANNELS and End Site; a second ROOT is refused."""
    names: list[str] = []
    parents: list[int] = []
    offsets: list[np.ndarray] = []
    channels: list[tuple[str, ...]] = []
    stack: list[int] = []
    opened = -1
    lines = [line.strip() for line in text.replace("{", "\n{\n").replace("}", "\n}\n").splitlines()]
    for number, line in enumerate(line for line in lines if line):
        word, _, rest = line.partition(" ") if " " in line else line.partition("\t")
        if word in ("ROOT", "JOINT"):
            if (word == "ROOT") == bool(names) or (word == "JOINT" and (not stack or stack[-1] < 0)):
                raise MotionBad(f"{name}: {word} out of place (a file has one ROOT).")
            names.append(keep_printable(rest.strip())[:80])
            parents.append(stack[-1] if stack else -1)
            offsets.append(np.zeros(3))
            channels.append(())
            opened = len(names) - 1
            if len(names) > MOST_JOINTS:
                raise MotionTooLarge(f"{name}: more than {MOST_JOINTS} joints.")
        elif line.startswith("End Site"):
            opened = -1
        elif word == "{":
            stack.append(opened)
        elif word == "}":
            if not stack:
                raise MotionBad(f"{name}: a bracket is closed that was not opened.")
            stack.pop()
        elif word == "OFFSET":
            if stack and stack[-1] >= 0:
                offsets[stack[-1]] = _three(rest, name)
        elif word == "CHANNELS":
            words = rest.split()
            if not stack or stack[-1] < 0 or not words or words[1:] != [w for w in words[1:] if w in CHANNELS]:
                raise MotionBad(f"{name}: channels '{keep_printable(rest)[:60]}' are none of {', '.join(CHANNELS)}.")
            if len(words) - 1 > 6 or words[0] != str(len(words) - 1):
                raise MotionBad(f"{name}: '{keep_printable(line)[:60]}' does not hold as many channels as it says.")
            channels[stack[-1]] = tuple(words[1:])
        elif number:
            raise MotionBad(f"{name}: '{keep_printable(line)[:40]}' is not understood. {MotionBad().message}")
    if stack or not names:
        raise MotionBad(f"{name}: the hierarchy is not closed, or empty. {MotionBad().message}")
    return Skeleton(tuple(names), tuple(parents), np.array(offsets), tuple(channels))


def _three(text: str, name: str) -> np.ndarray:
    try:
        found = np.array(text.split(), dtype=np.float64)
    except ValueError as error:
        raise MotionBad(f"{name}: an OFFSET is no numbers.") from error
    if found.shape != (3,) or not np.isfinite(found).all():
        raise MotionBad(f"{name}: an OFFSET is three numbers.")
    return found


def _after(lines: list[str], at: int, label: str, name: str) -> float:
    """Return the number behind a label."""
    line = lines[at] if at < len(lines) else ""
    try:
        found = float(line.removeprefix(label)) if line.startswith(label) else math.nan
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise MotionBad(f"{name}: '{label}' with a number is missing. {MotionBad().message}")
    return found
