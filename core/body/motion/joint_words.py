"""Split the names of a skeleton's joints into a side and a part of the body."""

from __future__ import annotations

import re
from enum import StrEnum
from functools import lru_cache


class Part(StrEnum):
    """List the parts of the body in joints' names."""

    HIP = "hip"
    THIGH = "thigh"
    LEG = "leg"
    SHIN = "shin"
    ANKLE = "ankle"
    FOOT = "foot"
    TOE = "toe"
    COLLAR = "collar"
    SHOULDER = "shoulder"
    ARM = "arm"
    UPPER_ARM = "upper arm"
    FOREARM = "forearm"
    WRIST = "wrist"
    HAND = "hand"
    SPINE = "spine"
    NECK = "neck"
    HEAD = "head"


PART_WORDS = {
    Part.HIP: ("hip", "hips"),
    Part.THIGH: ("thigh", "femur"),
    Part.LEG: ("leg",),
    Part.SHIN: ("shin", "calf", "knee", "tibia"),
    Part.ANKLE: ("ankle",),
    Part.FOOT: ("foot",),
    Part.TOE: ("toe", "toes", "ball"),
    Part.COLLAR: ("collar", "clavicle", "scapula"),
    Part.SHOULDER: ("shoulder", "shldr"),
    Part.ARM: ("arm",),
    Part.UPPER_ARM: ("humerus",),
    Part.FOREARM: ("elbow", "radius", "ulna"),
    Part.WRIST: ("wrist",),
    Part.HAND: ("hand",),
    Part.SPINE: ("spine", "chest", "abdomen", "torso", "thorax", "waist", "belly", "back"),
    Part.NECK: ("neck",),
    Part.HEAD: ("head", "skull"),
}
"""The words of each part; in a name with several the last part of this list counts, the outermost one."""

UPPER_HALF_WORDS, LOWER_HALF_WORDS = ("up", "upper", "u"), ("low", "lower", "fore", "f")
"""Words that make an arm or a leg its upper or its lower half, anywhere in the name."""

SIDE_WORDS = {"left": "left", "l": "left", "lf": "left", "lft": "left", "lt": "left",
         "right": "right", "r": "right", "rt": "right", "rgt": "right"}  # fmt: skip
"""Words of a side."""

SIDE_AFFIXES = ("left", "right", "l", "r")
"""Words of a side that may be joined to other known words: `lhip`, `RightUpLeg` in one case, `thighL`."""

FINE_PART_WORDS = ("finger", "thumb", "index", "middle", "ring", "pinky", "palm", "metacarpal", "metacarpals", "carpal",
        "eye", "jaw", "brow", "lip", "tongue", "cheek", "ear", "nose", "teeth", "lid", "hair")  # fmt: skip
"""Fingers and parts of a face."""

HELPER_WORDS = (
    "end",
    "nub",
    "site",
    "tip",
    "top",
    "ik",
    "pole",
    "target",
    "ctrl",
    "control",
    "helper",
    "effector",
    "prop",
)
"""Words of joints that are not the body's: ends of chains, handles of animators."""

TWIST_WORDS = ("twist", "roll")
"""Words of joints that divide a rotation about a bone's length."""

FILLER_WORDS = ("base", "bend", "joint", "jnt", "bone", "pelvis", "center", "mid", "big", "small", "in")
"""Further words that are joined to others and have no meaning here."""

KNOWN_WORDS = frozenset(
    [
        *(word for words in PART_WORDS.values() for word in words),
        "uarm",
        "farm",
        "uleg",
        "upleg",
        "uparm",
        *UPPER_HALF_WORDS[:2],
    ]
    + [*LOWER_HALF_WORDS[:3], *SIDE_AFFIXES[:2], *FINE_PART_WORDS, *HELPER_WORDS, *TWIST_WORDS, *FILLER_WORDS]
)

WORD_PATTERN = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|[0-9]+")
"""Pattern of a word in a name, by case."""

LIMB_HALF_PATTERN = re.compile(r"([LR])([UF])(Arm|Leg)")
"""A side, a half and a limb in capitals: `LUArm`, `RFArm`."""


def split_name(name: str) -> tuple[str, tuple[str, ...]]:
    """Return the side, `left`, `right` or none, and the other words of a joint's name, in lower case. What precedes a
    colon or a bar is not part of the name. Words end at signs, digits and capitals; a word of several known words, with
    or without a side's letter at either end, is split into them. The first side counts."""
    bare = re.split(r"[:|]", name)[-1] or name
    words: list[str] = []
    for piece in WORD_PATTERN.findall(LIMB_HALF_PATTERN.sub(r"\1 \2 \3", bare)):
        words.extend(_split_compound(piece.lower()))
    side = next((SIDE_WORDS[word] for word in words if word in SIDE_WORDS), "")
    return side, tuple(word for word in words if word not in SIDE_WORDS and not word.isdigit())


def name_part(words: tuple[str, ...]) -> Part | None:
    """Return the part of the body that a name's words mean; None for fingers, faces and helpers too."""
    if any(word in FINE_PART_WORDS or word in HELPER_WORDS for word in words):
        return None
    parts = [part for part, part_words in PART_WORDS.items() if any(word in part_words for word in words)]
    if not parts:
        return None
    part = parts[-1]
    if part in (Part.ARM, Part.LEG):
        upper, lower = (any(word in few for word in words) for few in (UPPER_HALF_WORDS, LOWER_HALF_WORDS))
        if upper != lower:
            joints = {Part.ARM: (Part.UPPER_ARM, Part.FOREARM), Part.LEG: (Part.THIGH, Part.SHIN)}
            return joints[part][lower]
    return part


@lru_cache(maxsize=4096)
def _split_compound(piece: str) -> tuple[str, ...]:
    """Return the known words in a piece of a name, the longest first one first; the piece itself if none."""
    if piece in SIDE_WORDS or piece in KNOWN_WORDS:
        return (*_split_limb_half(piece),)
    for side in ("", *SIDE_AFFIXES):
        if side and piece.startswith(side):
            rest = _segment_words(piece.removeprefix(side))
            if rest:
                return (side, *rest)
        if piece.endswith(side):
            rest = _segment_words(piece.removesuffix(side) if side else piece)
            if rest:
                return (*rest, side) if side else rest
    return (piece,)


def _segment_words(text: str) -> tuple[str, ...]:
    """Segment a text into known words; return an empty tuple where that fails."""
    found: dict[int, tuple[str, ...]] = {0: ()}
    for end in range(1, min(len(text), 80) + 1):
        for start in range(max(0, end - 11), end):
            if start in found and text[start:end] in KNOWN_WORDS:
                found.setdefault(end, (*found[start], *_split_limb_half(text[start:end])))
    return found.get(len(text), ()) if text else ()


def _split_limb_half(word: str) -> tuple[str, ...]:
    """Split a known word into the half and the limb where it has both."""
    for part in ("arm", "leg"):
        if word != part and word.endswith(part) and word.removesuffix(part) in (*UPPER_HALF_WORDS, *LOWER_HALF_WORDS):
            return word.removesuffix(part), part
    return (word,)
