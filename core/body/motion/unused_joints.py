"""Find which joints of a foreign skeleton were not used, and which of them matter."""

from __future__ import annotations

from .joint_names import Found
from .joint_words import HELPING, TWISTING, split_name
from .posed import Posed

LISTED = 8
"""Unused joints that are named; the others are counted."""

OUTERMOST = ("left_wrist", "right_wrist", "left_ankle", "right_ankle", "left_foot", "right_foot", "neck", "head")
"""Our joints beyond which a skeleton has fingers, toes and a face."""


def tell_unused(posed: Posed, found: Found) -> tuple[str, ...]:
    """Describe which joints were not used: those of trunk and limbs that turn, and all others, in a sentence each.

    What lies on a chain to a joint that was used is used with it, and so is what lies above the pelvis.
    """
    used: set[int] = set()
    for index in found.at.values():
        while index >= 0 and index not in used:
            used.add(index)
            index = posed.parents[index]
    fine = {found.at[name] for name in OUTERMOST if name in found.at}
    still = posed.still()
    matter: list[str] = []
    other: list[str] = []
    for joint, parent in enumerate(posed.parents):
        if joint in used:
            continue
        if parent in fine:
            fine.add(joint)
        words = split_name(posed.names[joint])[1]
        minor = joint in fine or joint in still or any(word in HELPING or word in TWISTING for word in words)
        (other if minor else matter).append(posed.names[joint])
    told = []
    if matter:
        told.append(f"Joints of trunk and limbs that turn and were not used: {_list(matter)}.")
    if other:
        told.append(f"Joints of the motion that were not used (fingers, face, ends, still): {_list(other)}.")
    return tuple(told)


def _list(names: list[str]) -> str:
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return f"{', '.join(names[:LISTED])}{more}"
