"""Find pieces that are cut twice, once mirrored, and pieces that are mirror images of themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.rigid import fit_rigid
from ..curves import edge_points
from ..pattern import EdgeRef, Pattern
from ..symmetry import find_symmetry
from .joining import Group
from .piece import PanelPlace

PIECE_MIRROR_TOLERANCE = 1e-4
"""Largest distance between a mirror image and its counterpart at which both are one drawn piece [m]: the accuracy of
scissors."""

MIRROR_EDGE_SEGMENT_COUNT = 16
"""Number of parts of an edge at whose ends a mirror image is compared."""


@dataclass(frozen=True, eq=False)
class MirroredGroup:
    """Describe that a group of panels is the mirror image of another, or of itself.

    Attributes:
        mirrors: For each of its edges, the pattern's edge whose mirror image it is, reversed.
        places: Placement of the panels of the mirrored copy; none where the group is its own mirror image.
        rotation, translation: The mirror map of the group's own points onto itself [m], shapes [2, 2], [2]; only where
            it is its own mirror image.
        is_symmetric: True where the group is its own mirror image.
    """

    group: Group
    mirrors: tuple[EdgeRef, ...]
    places: tuple[PanelPlace, ...]
    rotation: np.ndarray
    translation: np.ndarray
    is_symmetric: bool


def pair_groups(pattern: Pattern, groups: tuple[Group, ...]) -> tuple[Group | MirroredGroup, ...]:
    """Return the groups to be cut, each with its mirrored copy where it has one; copies are not listed again. The
    pattern's symmetry (`find_symmetry`) gives the pairs, and tolerates the noise of drafting; one drawn piece stands
    for two only where the outlines agree within `PIECE_MIRROR_TOLERANCE`."""
    twins = find_twins(pattern)
    home = {place.panel: group for group in groups for place in group.places}
    found: list[Group | MirroredGroup] = []
    copied: set[int | None] = set()
    for group in groups:
        if id(group) in copied:
            continue
        images = [twins.get(ref) for ref in group.sources]
        homes = {id(home[ref.panel]) if ref else None for ref in images}
        mirrored = None
        if len(homes) == 1 and None not in homes:
            refs = tuple(ref for ref in images if ref)
            mirrored = _match_mirrored_group(group, home[refs[0].panel], refs)
        if mirrored is not None:
            copied |= homes
        found.append(mirrored or group)
    return tuple(found)


def find_twins(pattern: Pattern) -> dict[EdgeRef, EdgeRef]:
    """Return for each edge the edge that is its mirror image, reversed."""
    twins = {}
    for mirror in find_symmetry(pattern).mirrors:
        source, target = pattern.panels[mirror.source], pattern.panels[mirror.target]
        count = len(mirror.order)
        for i in range(count):
            image = EdgeRef(source.name, int(mirror.order[i] - 1) % count)
            twins[EdgeRef(target.name, i)], twins[image] = image, EdgeRef(target.name, i)
    return twins


def _match_mirrored_group(group: Group, other: Group, mirrors: tuple[EdgeRef, ...]) -> MirroredGroup | None:
    """Return the mirror image of one group fitted to another; None where outlines or orders of edges differ."""
    numbers = [other.sources.index(ref) if ref in other.sources else -1 for ref in mirrors]
    steps = {(a - b) % len(numbers) for a, b in zip(numbers, np.roll(numbers, -1), strict=True)}
    if len(numbers) != len(other.sources) or steps != {1} or -1 in numbers:
        return None
    points = np.concatenate([edge_points(group.net, i, MIRROR_EDGE_SEGMENT_COUNT) for i in range(len(numbers))])
    its = np.concatenate([edge_points(other.net, number, MIRROR_EDGE_SEGMENT_COUNT)[::-1] for number in numbers])
    motion = fit_rigid(its, points, mirrored=True)
    misfit = float(np.linalg.norm(motion.apply(its) - points, axis=1).max())
    if misfit > PIECE_MIRROR_TOLERANCE:
        return None
    rotation, move = motion.rotation, motion.translation
    if other is group:
        return MirroredGroup(group, mirrors, (), rotation, move, is_symmetric=True)
    places = tuple(
        PanelPlace(p.panel, rotation @ p.rotation, rotation @ p.translation + move, misfit) for p in other.places
    )
    return MirroredGroup(group, mirrors, places, rotation, move, is_symmetric=False)
