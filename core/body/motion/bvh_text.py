"""Parse the text of BVH files with the variations that occur: any case, blanks, tabs, comma decimals."""

from __future__ import annotations

import codecs
import math
import re
from dataclasses import dataclass

import numpy as np

from ...run.errors import keep_printable
from .errors import MotionBad, MotionTooLarge
from .keys import FRAME_RATE_RANGE
from .recording import MAX_MOTION_FRAME_COUNT

MAX_JOINT_COUNT = 512
"""Largest number of joints; a skeleton with all fingers and a face has about 120."""

CHANNELS = {f"{axis}{kind}": (axis, kind) for axis in "XYZ" for kind in ("position", "rotation")}

CHANNELS_BY_LOWER_NAME = {name.lower(): name for name in CHANNELS}
"""The channels by their names in lower case."""

HIERARCHY_KEYWORDS = ("hierarchy", "root", "joint", "end", "offset", "channels", "{", "}")
"""First words of a line of the hierarchy, in lower case; a line with another first word continues the line before."""


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


@dataclass(frozen=True)
class BvhText:
    """Describe a BVH file: joints, channel `values` in the file's order, shape [frame_count, channel_count], `rate`
    [1/s], and notes on what the file announces but does not contain, one sentence each."""

    skeleton: Skeleton
    values: np.ndarray
    rate: float
    notes: tuple[str, ...] = ()


def decode_bvh(content: bytes) -> str:
    """Decode a file's text: UTF-16 if it has the byte order mark, else UTF-8 with invalid bytes replaced."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    return content.decode("utf-8-sig", errors="replace")


def parse_bvh(text: str, name: str) -> BvhText:
    """Return skeleton, channel values and rate of a BVH text.

    Raises:
        MotionBad: where it is not BVH, with what is wrong.
        MotionTooLarge: where it has too many joints or frames.
    """
    parts = re.split(r"^[ \t]*MOTION[ \t]*\r?$|(?<=\})\s*MOTION\b", text, maxsplit=1, flags=re.I | re.M)
    head = re.search(r"^\s*HIERARCHY\b", parts[0], flags=re.I | re.M)
    if len(parts) < 2 or head is None:
        raise MotionBad(f"{name}: a BVH file has HIERARCHY, then MOTION. {MotionBad().message}")
    skeleton = _parse_hierarchy(parts[0][head.end() :], name)
    lines = [line.strip() for line in parts[1].splitlines() if line.strip()]
    frames = _parse_labelled_number(lines, 0, "Frames", name)
    seconds = _parse_labelled_number(lines, 1, "Frame Time", name)
    if frames > MAX_MOTION_FRAME_COUNT:
        raise MotionTooLarge(
            f"{name}: {frames:g} frames are more than {MAX_MOTION_FRAME_COUNT}. {MotionTooLarge().message}"
        )
    if not frames >= 1 or not FRAME_RATE_RANGE[0] <= 1.0 / max(seconds, 1e-9) <= 1000.0:
        raise MotionBad(f"{name}: {frames:g} frames of {seconds:g} s make no motion.")
    width = sum(len(channels) for channels in skeleton.channels)
    values, notes = _parse_frames(lines[2:], int(frames), width, name)
    return BvhText(skeleton, values, 1.0 / seconds, notes)


def _parse_frames(lines: list[str], frames: int, width: int, name: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the values of each frame, shape [n, width], and notes on what differs from the file's header. A frame is a
    line; where lines are not as wide as the channels, frames continue across lines. An incomplete last frame is left
    out."""
    rows = _plain_decimals(lines)
    try:
        numbers = [np.array(row.split(), dtype=np.float64) for row in rows]
    except ValueError as error:
        raise MotionBad(f"{name}: the frames hold something that is no number. {MotionBad().message}") from error
    sizes, notes = [len(row) for row in numbers], []
    if width and len(sizes) > 1 and set(sizes[:-1]) == {width} and sizes[-1] < width:
        numbers, sizes = numbers[:-1], sizes[:-1]
        notes.append("The last frame breaks off, and was left out.")
    whole = bool(sizes) and set(sizes) == {width}
    values = np.concatenate(numbers) if numbers else np.zeros(0)
    if not width or not np.isfinite(values).all() or not (whole or values.size == frames * width):
        raise MotionBad(f"{name}: {values.size} values for {frames} frames of {width} channels.")
    values = values.reshape(-1, width)
    if len(values) > MAX_MOTION_FRAME_COUNT:
        raise MotionTooLarge(
            f"{name}: {len(values)} frames are more than {MAX_MOTION_FRAME_COUNT}. {MotionTooLarge().message}"
        )
    if len(values) != frames:
        notes.append(f"The file says {frames} frames and holds {len(values)}; those that it holds were read.")
    return values, tuple(notes)


def _parse_hierarchy(text: str, name: str) -> Skeleton:
    """Parse ROOT, JOINT, OFFSET, CHANNELS and End Site; a second ROOT is refused."""
    names: list[str] = []
    parents: list[int] = []
    offsets: list[np.ndarray] = []
    channels: list[tuple[str, ...]] = []
    stack: list[int] = []
    opened = -1
    for word, rest in _statements(text, name):
        inside = stack[-1] if stack else -1
        if word in ("root", "joint"):
            if (word == "root") == bool(names) or (word == "joint" and inside < 0):
                raise MotionBad(f"{name}: {word.upper()} out of place (a file has one ROOT).")
            names.append(keep_printable(rest)[:80])
            parents.append(inside)
            offsets.append(np.zeros(3))
            channels.append(())
            opened = len(names) - 1
            if len(names) > MAX_JOINT_COUNT:
                raise MotionTooLarge(f"{name}: more than {MAX_JOINT_COUNT} joints.")
        elif word == "end":
            opened = -1
        elif word == "{":
            stack.append(opened)
        elif word == "}":
            if not stack:
                raise MotionBad(f"{name}: a bracket is closed that was not opened.")
            stack.pop()
        elif word == "offset" and inside >= 0:
            offsets[inside] = _parse_offset(rest, name)
        elif word == "channels":
            if inside < 0:
                raise MotionBad(f"{name}: CHANNELS out of place.")
            channels[inside] = _parse_channels(rest, name)
    if stack or not names:
        raise MotionBad(f"{name}: the hierarchy is not closed, or empty. {MotionBad().message}")
    return Skeleton(tuple(names), tuple(parents), np.array(offsets), tuple(channels))


def _statements(text: str, name: str) -> list[tuple[str, str]]:
    """Split a hierarchy into statements: the first word in lower case, and the rest."""
    found: list[tuple[str, str]] = []
    for line in text.replace("{", "\n{\n").replace("}", "\n}\n").splitlines():
        word, *rest = line.split(maxsplit=1)[:2] or [""]
        if word.lower() in HIERARCHY_KEYWORDS:
            found.append((word.lower(), rest[0].strip() if rest else ""))
        elif word:
            if not found or found[-1][0] not in ("offset", "channels", "root", "joint"):
                shown = keep_printable(line.strip())[:40]
                raise MotionBad(f"{name}: '{shown}' is not understood. {MotionBad().message}")
            found[-1] = (found[-1][0], f"{found[-1][1]} {line.strip()}".strip())
    return found


def _parse_channels(text: str, name: str) -> tuple[str, ...]:
    """Parse the channels of a joint, named as in `CHANNELS`."""
    count, *words = text.replace(",", " ").split() or [""]
    if not all(word.lower() in CHANNELS_BY_LOWER_NAME for word in words):
        raise MotionBad(f"{name}: channels '{keep_printable(text)[:60]}' are none of {', '.join(CHANNELS)}.")
    if len(words) > 6 or count != str(len(words)):
        raise MotionBad(f"{name}: 'CHANNELS {keep_printable(text)[:60]}' does not hold as many channels as it says.")
    return tuple(CHANNELS_BY_LOWER_NAME[word.lower()] for word in words)


def _plain_decimals(lines: list[str]) -> list[str]:
    """Return lines of numbers with decimal points and blanks as separators. A comma between two digits is a decimal one
    where no number has a point and none has two commas; else it separates."""
    text = "\n".join(lines)
    if "," not in text:
        return lines
    decimal = "." not in text and not re.search(r",[^,\s]*,|,\s|,$|(^|\s),", text)
    return text.replace(",", "." if decimal else " ").split("\n")


def _parse_offset(text: str, name: str) -> np.ndarray:
    try:
        found = np.array(_plain_decimals([text])[0].split(), dtype=np.float64)
    except ValueError as error:
        raise MotionBad(f"{name}: an OFFSET is no numbers.") from error
    if found.shape != (3,) or not np.isfinite(found).all():
        raise MotionBad(f"{name}: an OFFSET is three numbers.")
    return found


def _parse_labelled_number(lines: list[str], at: int, label: str, name: str) -> float:
    """Parse the number after a label and a colon."""
    line = lines[at] if at < len(lines) else ""
    spaced = label.replace(" ", r"\s*")
    match = re.fullmatch(rf"{spaced}\s*:?\s*(\S+)", line, flags=re.I)
    try:
        found = float(match[1].replace(",", ".")) if match else math.nan
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise MotionBad(f"{name}: '{label}:' with a number is missing. {MotionBad().message}")
    return found
