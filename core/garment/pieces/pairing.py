"""Find pieces that are cut twice, once mirrored, and pieces that are mirror images of themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.rigid import fit_rigid
from ..curves import edge_points
from ..mirrors import PLACE_TOLERANCE
from ..orientation import place_points
from ..pattern import EdgeRef, Pattern
from ..symmetry import find_symmetry
from .flatten import distance_to_line, flatten_edge, flatten_outline
from .joining import Group
from .piece import PanelPlace

PIECE_MIRROR_TOLERANCE = 1e-4
"""Largest distance between a mirror image and its counterpart at which both are one drawn piece [m]: the accuracy of
scissors."""

TRUED_MIRROR_TOLERANCE = 1e-3
"""Largest distance to which trueing may move such outlines apart [m]: it bends different parts of edges that are cut
differently, by 0.6 to 0.8 mm on a published jumpsuit; cutting cloth is no more exact."""

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


def pair_groups(
    pattern: Pattern, groups: tuple[Group, ...], drafted: tuple[Group, ...] | None = None
) -> tuple[Group | MirroredGroup, ...]:
    """Return the groups to be cut, each with its mirrored copy where it has one; copies are not listed again. The
    pattern's symmetry (`find_symmetry`) gives the pairs, and tolerates the noise of drafting; one drawn piece stands
    for two only where the outlines agree within `PIECE_MIRROR_TOLERANCE`. Where a file divides the edges of left and
    right differently, the left one is drawn for both.

    Args:
        pattern: The pattern.
        groups: Its groups.
        drafted: The groups of the same panels before trueing, whose outlines are to agree; None for `groups`.
    """
    before = {group.places[0].panel: group for group in drafted or groups}
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
        elif pattern.symmetric:
            others = [other for other in groups if other is not group and id(other) not in copied]
            matching = (other for other in others if _is_mirrored(pattern, group, other, before))
            other = next(matching, None)
            if other is not None:
                sides = sorted((group, other), key=lambda one: -float(_place_middle(pattern, one)[0]))
                group, mirrored = sides[0], _mirror_outline(*sides)
        if mirrored is not None:
            copied |= {id(home[place.panel]) for place in (*mirrored.places, *group.places)}
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


def _is_mirrored(pattern: Pattern, group: Group, other: Group, before: dict[str, Group]) -> bool:
    """Check whether two groups are on both sides of the wearer and have one outline, cut into edges in two ways."""
    draft, other_draft = (before.get(one.places[0].panel) for one in (group, other))
    if draft is None or other_draft is None or len(group.places) != len(other.places):
        return False
    x = np.concatenate([place_points(panel, panel.points)[:, 0] for panel in pattern.panels])
    image = _place_middle(pattern, other) * [-1.0, 1.0, 1.0] + [x.min() + x.max(), 0.0, 0.0]
    size = float(np.linalg.norm(np.ptp(group.net.points, axis=0)))
    if np.linalg.norm(_place_middle(pattern, group) - image) > PLACE_TOLERANCE * size:
        return False
    return _misfit(draft, other_draft) < PIECE_MIRROR_TOLERANCE and _misfit(group, other) < TRUED_MIRROR_TOLERANCE


def _place_middle(pattern: Pattern, group: Group) -> np.ndarray:
    """Return the middle of a group's panels as placed [m], shape [3]."""
    panels = [pattern.panel(place.panel) for place in group.places]
    return np.asarray(np.concatenate([place_points(panel, panel.points) for panel in panels]).mean(axis=0))


def _lay_mirrored(group: Group, other: Group) -> np.ndarray:
    """Return the move of another group's mirror image onto a group, box on box [m], shape [2]; both lie grain up."""
    own, image = (flatten_outline(one.net)[0] * side for one, side in ((group, 1.0), (other, [-1.0, 1.0])))
    return np.asarray((own.min(axis=0) + own.max(axis=0) - image.min(axis=0) - image.max(axis=0)) / 2.0)


def _misfit(group: Group, other: Group) -> float:
    """Return the largest distance between a group's outline and the mirror image of another one's [m]."""
    own, image = (
        flatten_outline(group.net)[0],
        flatten_outline(other.net)[0] * [-1.0, 1.0] + _lay_mirrored(group, other),
    )
    if np.abs(np.ptp(own, axis=0) - np.ptp(image, axis=0)).max() > 2.0 * TRUED_MIRROR_TOLERANCE:
        return float("inf")
    return float(max(distance_to_line(own, image).max(), distance_to_line(image, own).max()))


def _mirror_outline(group: Group, other: Group) -> MirroredGroup:
    """Return a group with another one as its mirrored copy; each edge is the image of the nearest edge there."""
    rotation, move = np.diag([-1.0, 1.0]), _lay_mirrored(group, other)
    lines = [flatten_edge(other.net, i) @ rotation.T + move for i in range(len(other.sources))]
    middles = np.array([edge_points(group.net, i, 2)[1] for i in range(len(group.sources))])
    nearest = np.argmin([distance_to_line(middles, line, is_closed=False) for line in lines], axis=0)
    misfit = _misfit(group, other)
    places = tuple(
        PanelPlace(p.panel, rotation @ p.rotation, rotation @ p.translation + move, misfit) for p in other.places
    )
    refs = tuple(other.sources[k] for k in nearest)
    return MirroredGroup(group, refs, places, rotation, move, is_symmetric=False)
