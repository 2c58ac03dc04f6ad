"""Names that other skeletons give to our joints."""

from __future__ import annotations

import re

SIDED = {
    "hip": ("upleg", "thigh", "hip", "upperleg", "femur"),
    "knee": ("leg", "calf", "knee", "lowleg", "lowerleg", "shin", "tibia"),
    "ankle": ("foot", "ankle"),
    "foot": ("toebase", "toe", "toe0", "toes", "ball"),
    "collar": ("shoulder", "collar", "clavicle"),
    "shoulder": ("arm", "upperarm", "uparm", "shoulder", "humerus"),
    "elbow": ("forearm", "elbow", "lowarm", "lowerarm", "radius"),
    "wrist": ("hand", "wrist"),
}
"""Our joints of a side. `shoulder` is the collar of skeletons that have an arm below it, else the shoulder itself; SMPL
calls the toes `foot` and the ankle `ankle`."""


def split_side(name: str) -> tuple[str, str]:
    """Return the side, `left`, `right` or none, and the part that a joint's name speaks of, in lower case.

    Prefixes with a colon (`mixamorig:`), of 3ds Max' bipeds (`Bip01`) and of SMPL (`m_avg_`) do not count.
    """
    bare = re.sub(r"^[mf]_avg_", "", name.rpartition(":")[2], flags=re.I)
    bare = re.sub(r"^(mixamorig\d*|bip\d*|biped|def[-_]?)[-_ .]*", "", bare, flags=re.I)
    words = re.sub(r"[^A-Za-z0-9]+", " ", bare).strip()
    for side, letter in (("left", "l"), ("right", "r")):
        lower = words.lower()
        if lower.startswith(side) or lower.endswith(side):
            return side, re.sub(r"\s", "", lower.removeprefix(side).removesuffix(side))
        parts = lower.split()
        if len(parts) > 1 and letter in (parts[0], parts[-1]):
            rest = parts[1:] if parts[0] == letter else parts[:-1]
            return side, "".join(rest)
        if re.match(rf"{letter.upper()}[A-Z]", words) or (words[:1] == letter and re.match(r"[A-Z]", words[1:2])):
            return side, words[1:].lower().replace(" ", "")
    return "", re.sub(r"\s", "", words.lower())


def find_joints(names: tuple[str, ...], parents: tuple[int, ...]) -> dict[str, int]:
    """Return our joints' names with the index of the joint that is meant among others' names.

    The root is the pelvis. The chest is where the arms branch off; the joints between pelvis and chest are shared among
    the spine's three, and the one above the chest is the neck.
    """
    parts = [split_side(name) for name in names]
    found, taken = {"pelvis": 0}, {0}
    for side in ("left", "right"):
        own: dict[str, int] = {}
        for index, (of, part) in enumerate(parts):
            if of == side:
                own.setdefault(part, index)
        has_arm = any(part in own for part in ("arm", "upperarm", "uparm", "humerus"))
        for joint, words in SIDED.items():
            if joint == "collar" and not has_arm:
                words = ("collar", "clavicle")
            extra = ("foot",) if joint == "foot" else ()
            index = next((own[word] for word in (*words, *extra) if word in own and own[word] not in taken), -1)
            if index >= 0:
                found[f"{side}_{joint}"] = index
                taken.add(index)
    head = next((index for index, (side, part) in enumerate(parts) if not side and part == "head"), -1)
    if head > 0:
        found["head"] = head
    found |= _find_spine(found, parents)
    return found


def _find_spine(found: dict[str, int], parents: tuple[int, ...]) -> dict[str, int]:
    """Return the joints of spine and neck by the chains that lead to arms and head."""
    tops = [found[name] for name in ("left_shoulder", "right_shoulder", "head") if name in found]
    if len(tops) < 2:
        return {}
    chains = [_chain_to(top, parents) for top in tops]
    shared = [joint for joint in chains[0] if all(joint in chain for chain in chains)]
    spine = [joint for joint in shared if joint != 0]
    placed = {f"spine{k}": spine[-(-k * len(spine) // 3) - 1] for k in (1, 2, 3)} if spine else {}
    if "head" in found:
        above = [joint for joint in _chain_to(found["head"], parents) if joint not in shared and joint != found["head"]]
        if above:
            placed["neck"] = above[0]
    return placed


def _chain_to(joint: int, parents: tuple[int, ...]) -> list[int]:
    """Return the joints from the root to a joint."""
    chain = [joint]
    while parents[chain[-1]] >= 0:
        chain.append(parents[chain[-1]])
    return chain[::-1]
