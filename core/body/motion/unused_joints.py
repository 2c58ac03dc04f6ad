"""Find which joints of a foreign skeleton were not used, and which of them matter."""

from __future__ import annotations

from .joint_names import JointMapping
from .joint_words import HELPER_WORDS, TWIST_WORDS, split_name
from .posed import SkeletonMotion

MAX_LISTED_JOINTS = 8
"""Largest number of unused joints that are named; the others are counted."""

OUTERMOST_JOINTS = ("left_wrist", "right_wrist", "left_ankle", "right_ankle", "left_foot", "right_foot", "neck", "head")
"""Our joints beyond which a skeleton has fingers, toes and a face."""


def describe_unused_joints(posed: SkeletonMotion, found: JointMapping) -> tuple[str, ...]:
    """Describe the unused joints: those of trunk and limbs that turn, and all others, in a sentence each. Joints on a
    chain to a used joint count as used, and so do those above the pelvis."""
    used: set[int] = set()
    for index in found.at.values():
        while index >= 0 and index not in used:
            used.add(index)
            index = posed.parents[index]
    fine = {found.at[name] for name in OUTERMOST_JOINTS if name in found.at}
    fixed = posed.fixed_joints()
    matter: list[str] = []
    other: list[str] = []
    for joint, parent in enumerate(posed.parents):
        if joint in used:
            continue
        if parent in fine:
            fine.add(joint)
        words = split_name(posed.names[joint])[1]
        minor = joint in fine or joint in fixed or any(word in HELPER_WORDS or word in TWIST_WORDS for word in words)
        (other if minor else matter).append(posed.names[joint])
    notes = []
    if matter:
        notes.append(f"Joints of trunk and limbs that turn and were not used: {_list(matter)}.")
    if other:
        notes.append(f"Joints of the motion that were not used (fingers, face, ends, still): {_list(other)}.")
    return tuple(notes)


def _list(names: list[str]) -> str:
    more = f" and {len(names) - MAX_LISTED_JOINTS} more" if len(names) > MAX_LISTED_JOINTS else ""
    return f"{', '.join(names[:MAX_LISTED_JOINTS])}{more}"
