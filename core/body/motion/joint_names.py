"""Match a foreign skeleton's joints to `JOINTS`: by their names, else by the tree and the rest pose."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ...geometry.geometry import unit
from .joint_tree import JointTree, MirroredChains
from .joint_words import TWIST_WORDS, Part

SIDES = ("left", "right")

LEG = ("hip", "knee", "ankle", "foot")
ARM = ("collar", "shoulder", "elbow", "wrist")
"""The joints of a leg and of an arm, from the trunk outwards."""

BONES = ("hip", "knee", "collar", "shoulder", "elbow")
"""Joints whose bone may be divided among several foreign joints; the last of these carries the next joint."""

PART_JOINT_SCORES: dict[Part, dict[str, float]] = {
    Part.HIP: {"hip": 0.8},
    Part.THIGH: {"hip": 1.0},
    Part.LEG: {"knee": 1.0, "hip": 0.5},
    Part.SHIN: {"knee": 1.0},
    Part.ANKLE: {"ankle": 1.0},
    Part.FOOT: {"ankle": 0.9, "foot": 0.5},
    Part.TOE: {"foot": 1.0},
    Part.COLLAR: {"collar": 1.0},
    Part.SHOULDER: {"shoulder": 0.8, "collar": 0.7},
    Part.ARM: {"shoulder": 1.0},
    Part.UPPER_ARM: {"shoulder": 1.0},
    Part.FOREARM: {"elbow": 1.0},
    Part.WRIST: {"wrist": 1.0},
    Part.HAND: {"wrist": 0.9},
}
"""Score of each joint for each part of a name: `hip` is the hip joint unless a thigh follows, `foot` the ankle unless
an ankle precedes, `shoulder` the collar if an arm follows."""

TWIST_JOINT_SCORE_FACTOR = 0.3
"""Factor on the name score of a twist joint: it is along the bone, not at its end."""

STILL_JOINT_SCORE_FACTOR = 0.95
"""Factor on the name score of a joint that never turns; of two joints of one name it is not the one that moves."""

MIN_HANGING_LEG_COSINE = 0.7
"""Smallest cosine between a leg and the way from chest to pelvis at which the leg hangs below the trunk: 45 degrees."""


@dataclass
class JointMapping:
    """Describe the mapping from `JOINTS` to the joints of a foreign skeleton.

    Attributes:
        at: Index of the joint at the same place, by the name in `JOINTS`.
        carried: Index of the joint whose rotation our bone has: the last one of several that divide the bone.
        notes: What was recognised by place alone, one sentence each.
    """

    at: dict[str, int] = field(default_factory=dict)
    carried: dict[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def find_joints(tree: JointTree, fixed: frozenset[int] = frozenset()) -> JointMapping:
    """Match the joints of a foreign skeleton to `JOINTS`.

    Legs and arms are the chains whose names fit best; those without usable names are found by place: the two longest
    bones. The pelvis is where both legs branch, the chest where the arms do; joints between are divided among the
    spine's three, and those above the chest are neck and head.

    Args:
        tree: The skeleton.
        fixed: Joints that never turn in the motion: ignored in the spine, of low score in limbs.
    """
    found = JointMapping()
    for limb in (LEG, ARM):
        for side in SIDES:
            found.at |= {f"{side}_{name}": joint for name, joint in _name_limb(tree, side, limb, fixed).items()}
    _fill_limbs(tree, found)
    _fill_ends(tree, found)
    legs = [found.at[f"{side}_hip"] for side in SIDES if f"{side}_hip" in found.at]
    if len(legs) == 2 and (pelvis := tree.fork(legs)) >= 0 and pelvis not in legs:
        found.at["pelvis"] = pelvis
        _find_trunk(tree, found, fixed)
    found.carried = {name: _rotation_source(tree, found.at, name) for name in found.at}
    return found


def _name_limb(tree: JointTree, side: str, limb: tuple[str, ...], fixed: frozenset[int]) -> dict[str, int]:
    """Find the joints of a limb along the chain whose names fit best. Dynamic programming: for each joint, and each
    number of the limb's joints assigned so far, the best assignment is kept; of equal ones that nearer to the trunk."""
    none: tuple[float, tuple[tuple[str, int], ...]] = (0.0, ())
    best = [[none] * (len(limb) + 1) for _ in tree.parents]
    top = none
    for joint, parent in enumerate(tree.parents):
        before = best[parent] if parent >= 0 else [none] * (len(limb) + 1)
        part, (part_limb, words) = tree.parts[joint], tree.words[joint]
        claims = PART_JOINT_SCORES.get(part, {}) if part is not None and part_limb == side else {}
        share = (
            TWIST_JOINT_SCORE_FACTOR
            if any(word in TWIST_WORDS for word in words)
            else STILL_JOINT_SCORE_FACTOR
            if joint in fixed
            else 1.0
        )
        for count, name in enumerate(limb, 1):
            score, count_used = before[count - 1]
            claim = claims.get(name, 0.0) * share
            options = [before[count], best[joint][count - 1]]
            if claim:
                options.append((score + claim, (*count_used, (name, joint))))
            best[joint][count] = max(options, key=lambda option: option[0])
        if best[joint][-1][0] > top[0] + 1e-9:
            top = best[joint][-1]
    return dict(top[1])


def _fill_limbs(tree: JointTree, found: JointMapping) -> None:
    """Find the joints of legs and arms that names do not give, by place."""
    for limb in (LEG, ARM):
        three = limb[:3] if limb is LEG else limb[1:]
        for side, other in (SIDES, SIDES[::-1]):
            joints = [found.at[f"{side}_{name}"] for name in limb if f"{side}_{name}" in found.at]
            if joints and any(f"{side}_{name}" not in found.at for name in three):
                first, middle, last = (found.at.get(f"{side}_{name}", -1) for name in three)
                across = {joint for name in limb if (joint := found.at.get(f"{other}_{name}", -1)) >= 0}
                chain = _limb_of(tree, joints, across)
                _assign_joints(tree, found, side, three, tree.three_of(chain, (first, middle, last)))
    _find_mirrored(tree, found)


def _fill_ends(tree: JointTree, found: JointMapping) -> None:
    """Find by place the collars, between the arms' fork and their shoulders, and the toes, beyond the ankles."""
    shoulders = [found.at[f"{side}_shoulder"] for side in SIDES if f"{side}_shoulder" in found.at]
    chest = tree.fork(shoulders) if len(shoulders) == 2 else -1
    for side in SIDES:
        used = set(found.at.values())
        if f"{side}_collar" not in found.at and f"{side}_shoulder" in found.at and chest >= 0:
            path = tree.path_to(found.at[f"{side}_shoulder"])
            _assign_joints(tree, found, side, ("collar",), tuple(path[path.index(chest) + 1 : -1][:1]))
        if f"{side}_foot" not in found.at and f"{side}_ankle" in found.at:
            toes = tree.chain_below(found.at[f"{side}_ankle"])[1:2]
            _assign_joints(tree, found, side, ("foot",), tuple(j for j in toes if j not in used and not tree.is_end(j)))


def _limb_of(tree: JointTree, joints: list[int], across: set[int]) -> list[int]:
    """Return the chain with some joints of a limb, without what it shares with the other side or the trunk."""
    path = [*tree.path_to(joints[-1])[:-1], *tree.chain_below(joints[-1])]
    shared = {joint for other in across for joint in tree.path_to(other)}
    first = next((n for n, joint in enumerate(path) if joint not in shared), 0) if shared else 0
    return path[min(first, path.index(joints[0])) :]


def _assign_joints(
    tree: JointTree, found: JointMapping, side: str, names: tuple[str, ...], three: tuple[int, ...] | None
) -> None:
    """Store the joints of a limb that were found by place, with a note for each."""
    for name, joint in zip(names, three or (), strict=False):
        if f"{side}_{name}" not in found.at:
            found.at[f"{side}_{name}"] = joint
            found.notes = (*found.notes, f"{side}_{name} was found by its place: {tree.names[joint]}.")


def _find_mirrored(tree: JointTree, found: JointMapping) -> None:
    """Find legs and arms without usable names: two pairs of chains, each other's mirror image. Legs hang below the way
    from the arms' fork to theirs. The left side is by named limbs, else by the toes' direction."""
    lacking = [limb for limb in (LEG[:3], ARM[1:]) if not any(f"{side}_{limb[0]}" in found.at for side in SIDES)]
    if not lacking:
        return
    pairs = [pair for pair in tree.mirrored() if not {*pair.first, *pair.second} & set(found.at.values())]
    legs: MirroredChains | None = None
    if LEG[:3] in lacking:
        legs = next(
            (pair for pair in pairs if any(_hangs_below_trunk(tree, pair, other.fork) for other in pairs)), None
        )
    used = () if legs is None else (legs.fork,)
    arms = next((pair for pair in pairs if ARM[1:] in lacking and pair.fork not in used), None)
    left = _left_direction(tree, found, legs)
    if not left.any():
        return
    for pair, names in ((legs, LEG[:3]), (arms, ARM[1:])):
        if pair is None:
            continue
        is_left = (tree.places[pair.first[0]] - tree.places[pair.second[0]]) @ left > 0
        for side, chain in zip(SIDES if is_left else SIDES[::-1], (pair.first, pair.second), strict=True):
            _assign_joints(tree, found, side, names, tree.three_of(list(chain), (-1, -1, -1)))


def _hangs_below_trunk(tree: JointTree, pair: MirroredChains, chest: int) -> bool:
    """Check whether a pair of chains hangs below a trunk that ends at a chest."""
    down = unit(tree.places[pair.fork] - tree.places[chest])
    ways = [tree.places[chain[2]] - tree.places[chain[0]] for chain in (pair.first, pair.second)]
    return all(unit(direction) @ down > MIN_HANGING_LEG_COSINE for direction in ways)


def _left_direction(tree: JointTree, found: JointMapping, legs: MirroredChains | None) -> np.ndarray:
    """Return a direction to the left in the rest pose, shape [3]; zeros where it is unknown."""
    for name in ("hip", "shoulder", "knee", "elbow"):
        if all(f"{side}_{name}" in found.at for side in SIDES):
            return np.asarray(tree.places[found.at[f"left_{name}"]] - tree.places[found.at[f"right_{name}"]])
    if legs is None:
        return np.zeros(3)
    three = tree.three_of(list(legs.first), (-1, -1, -1))
    ends = legs.first[legs.first.index(three[2]) :] if three else legs.first[-1:]
    up = tree.places[legs.first[0]] - tree.places[ends[0]]
    return np.cross(up, tree.places[ends[-1]] - tree.places[ends[0]])


def _find_trunk(tree: JointTree, found: JointMapping, fixed: frozenset[int]) -> None:
    """Find spine, neck and head: the joints between the forks of legs and arms, and those above."""
    tops = [
        next((found.at[f"{side}_{name}"] for name in ARM[:2] if f"{side}_{name}" in found.at), -1) for side in SIDES
    ]
    tops = [joint for joint in tops if joint >= 0]
    head = next((j for j, part in enumerate(tree.parts) if part is Part.HEAD and not tree.words[j][0]), -1)
    ends = [*tops, head] if head >= 0 else tops
    if not ends:
        return
    chest = tree.fork(ends) if len(ends) > 1 else tree.parents[ends[0]]
    if chest < 0:
        return
    below = tree.path_to(found.at["pelvis"])
    above = [joint for joint in tree.path_to(chest) if joint not in below]
    necks = [joint for joint in above if tree.parts[joint] is Part.NECK]  # some skeletons hang the arms on the neck
    spine = [joint for joint in above if joint not in necks]
    spine = [joint for joint in spine if joint not in fixed] or spine
    found.at |= {f"spine{k}": spine[-(-k * len(spine) // 3) - 1] for k in (1, 2, 3)} if spine else {}
    upper = _neck_and_head(tree, chest, tops, head)
    necks += [joint for joint in upper[:-1] if joint not in necks]
    if upper:
        found.at["head"] = upper[-1]
    if necks:
        found.at["neck"] = necks[0]


def _neck_and_head(tree: JointTree, chest: int, tops: list[int], head: int) -> list[int]:
    """Return the joints from neck to head: those above the chest that carry no arm. The last is the head."""
    if head >= 0:
        path = tree.path_to(head)
        return path[path.index(chest) + 1 :] if chest in path else [head]
    chain = [chest]
    while chain[-1] >= 0:
        ways = [child for child in tree.children[chain[-1]] if not _is_side_branch(tree, child, tops)]
        if not ways or (len(chain) > 1 and len(ways) > 1):  # a face branches
            break
        chain.append(max(ways, key=lambda child: tree.depths[child]))
    return chain[1:]


def _is_side_branch(tree: JointTree, joint: int, tops: list[int]) -> bool:
    """Check whether a joint above the chest leads to an arm, has a side, or is only an end of a chain."""
    return bool(tree.words[joint][0]) or tree.is_end(joint) or any(joint in tree.path_to(top) for top in tops)


def _rotation_source(tree: JointTree, at: dict[str, int], name: str) -> int:
    """Return the joint whose rotation one of our bones has."""
    side = name.partition("_")[0]
    ends = {"neck": "head", **{f"{side}_{first}": f"{side}_{second}" for limb in (LEG, ARM)
            for first, second in pairwise(limb) if first in BONES}}  # fmt: skip
    end = at.get(ends.get(name, ""), -1)
    if end >= 0 and at[name] in tree.path_to(end)[:-1]:
        return tree.parents[end]
    return at[name]
