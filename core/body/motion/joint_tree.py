"""The tree of a foreign skeleton's joints, with their places in its rest pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from ...geometry.geometry import unit
from .joint_words import HELPER_WORDS, Part, name_part, split_name

MIN_BONE_LENGTH_RATIO = 0.6
"""Smallest ratio of a limb's two bones' lengths: thigh and shin, upper arm and forearm 0.8 to 1, a twist bone 0.5."""

MIRROR_LIKENESS = 0.9
"""Share of the distance from the fork in which mirrored chains agree: persons are symmetric to 5 %."""


@dataclass(frozen=True)
class MirroredChains:
    """Describe mirrored chains: the joint from which they branch, and their joints from its child to the end."""

    fork: int
    first: tuple[int, ...]
    second: tuple[int, ...]


@dataclass(frozen=True)
class JointTree:
    """Describe the joints of a foreign skeleton: names, indices of parents, which come first (-1: the root), and places
    in the rest pose, in the file's unit and axes, shape [joint_count, 3]."""

    names: tuple[str, ...]
    parents: tuple[int, ...]
    places: np.ndarray

    @cached_property
    def words(self) -> list[tuple[str, tuple[str, ...]]]:
        """Return the side and the other words of each joint's name."""
        return [split_name(name) for name in self.names]

    @cached_property
    def parts(self) -> list[Part | None]:
        """Return the part of the body that each joint's name has."""
        return [name_part(words) for _, words in self.words]

    @cached_property
    def children(self) -> list[list[int]]:
        """Return the children of each joint."""
        found: list[list[int]] = [[] for _ in self.parents]
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                found[parent].append(joint)
        return found

    @cached_property
    def depths(self) -> np.ndarray:
        """Return the length of the longest chain below each joint, in the file's unit, shape [joint_count]."""
        found = np.zeros(len(self.parents))
        for joint in range(len(self.parents) - 1, 0, -1):
            parent = self.parents[joint]
            if parent >= 0:
                found[parent] = max(found[parent], found[joint] + self.length(parent, joint))
        return found

    def is_end(self, joint: int) -> bool:
        """Check whether a joint is named as an end of a chain, or as a handle."""
        return any(word in HELPER_WORDS for word in self.words[joint][1])

    def length(self, first: int, second: int) -> float:
        """Return the distance of two joints, in the file's unit."""
        return float(np.linalg.norm(self.places[first] - self.places[second]))

    def path_to(self, joint: int) -> list[int]:
        """Return the joints from the root to a joint."""
        chain = [joint]
        while self.parents[chain[-1]] >= 0:
            chain.append(self.parents[chain[-1]])
        return chain[::-1]

    def fork(self, joints: list[int]) -> int:
        """Return the joint at which the chains to some joints branch, -1 where they share none."""
        ways = [self.path_to(joint) for joint in joints]
        shared = [joint for joint in ways[0] if all(joint in path for path in ways)]
        return shared[-1] if shared else -1

    def chain_below(self, joint: int) -> list[int]:
        """Return the longest chain that begins with a joint."""
        chain = [joint]
        while self.children[chain[-1]]:
            last = chain[-1]
            chain.append(max(self.children[last], key=lambda child: self.depths[child] + self.length(last, child)))
        return chain

    def three_of(self, chain: list[int], known: tuple[int, int, int]) -> tuple[int, int, int] | None:
        """Find the three joints at the ends of a limb's two bones, by place; None where the chain has none.

        Beside one known bone the other is the first of similar length; between two known ends the middle joint is that
        which halves them best; otherwise the bones are the two consecutive ones that are longest.

        Args:
            chain: The joints along the limb.
            known: Those of the three that are known, -1 for others.
        """
        first, middle, last = known
        at = {joint: number for number, joint in enumerate(chain)}
        if first >= 0 and last >= 0 and middle < 0:
            between = chain[at[first] + 1 : at[last]]
            found = max(between, key=lambda j: min(self.length(first, j), self.length(j, last)), default=-1)
            return (first, found, last) if found >= 0 else None
        if middle >= 0 and (first >= 0) != (last >= 0):
            end = first if first >= 0 else last
            others = chain[at[middle] + 1 :] if first >= 0 else chain[: at[middle]][::-1]
            found = next(
                (j for j in others if self.length(middle, j) > MIN_BONE_LENGTH_RATIO * self.length(middle, end)), -1
            )
            return None if found < 0 else (first, middle, found) if first >= 0 else (found, middle, last)
        threes = [
            three
            for three in zip(chain, chain[1:], chain[2:], strict=False)
            if all(known_joint in (-1, joint) for known_joint, joint in zip(known, three, strict=True))
        ]
        return max(threes, key=lambda t: min(self.length(t[0], t[1]), self.length(t[1], t[2])), default=None)

    def mirrored(self) -> list[MirroredChains]:
        """Return pairs of mirrored chains, the longest first, of at least three bones as legs and arms have."""
        found = []
        for joint, children in enumerate(self.children):
            chains = [tuple(self.chain_below(child)) for child in children]
            for first, second in combinations([chain for chain in chains if len(chain) >= 3], 2):
                if self._is_mirror(joint, first, second):
                    found.append(MirroredChains(joint, first, second))
        return sorted(found, key=lambda pair: -self.depths[pair.first[0]])

    def _is_mirror(self, fork: int, first: tuple[int, ...], second: tuple[int, ...]) -> bool:
        """Check whether two chains that branch from a joint are each other's mirror image."""
        across = unit(self.places[first[0]] - self.places[second[0]])
        if not across.any():
            return False
        for one, other in zip(first[:3], second[:3], strict=True):
            a, b = self.places[one] - self.places[fork], self.places[other] - self.places[fork]
            a = a - 2.0 * (a @ across) * across
            size = max(float(np.linalg.norm(a)), float(np.linalg.norm(b)))
            if size > 0 and np.linalg.norm(a - b) > (1.0 - MIRROR_LIKENESS) * size:
                return False
        return True
