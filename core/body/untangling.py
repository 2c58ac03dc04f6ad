"""Untangle cloth that crosses itself, and keep it outside of the body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.intersections import self_intersections
from ..geometry.move_towards import move_towards
from ..geometry.untangling import UntangleSettings, untangle
from .exposed import ExposedSurface, penetration_depth
from .projection import limit_penetration, project_outside


@dataclass(frozen=True)
class SeparationSettings:
    """Describe how cloth that crosses itself beside a body is separated.

    Attributes:
        step: Step of the first untangling [m], as in `UntangleSettings`.
        untanglings: Largest number of untanglings; moving cloth out of the body may make it cross again. Where one does
            not reduce the crossing faces, the room is too small: of 9 further ones, in trousers, one did.
        gap_untanglings: Largest number of them in a gap of the body; trousers between thighs that touch took four.
        gap_step: Step of untangling in such a gap [m]: the largest distance of layers afterwards.
        raised_share: Share of the allowed depth to which cloth in such a gap is raised; the rest is for separation.
        allowed: Depth in the body that is not corrected [m]: half of what a result may have.
        limit: Depth that is accepted [m] where untangling needs it and no cloth was deeper: what a result may have.
    """

    step: float = UntangleSettings.step
    untanglings: int = 4
    gap_untanglings: int = 12
    gap_step: float = 5e-5
    raised_share: float = 0.9
    allowed: float = 5e-4
    limit: float = 1e-3


def untangle_outside(
    nodes: np.ndarray, skin: ExposedSurface, faces: np.ndarray, settings: SeparationSettings = SeparationSettings()
) -> np.ndarray:
    """Untangle cloth that crosses itself, and move it out of the body again where that led into it.

    Cloth that does not cross then returns towards its former place as far as its layers let it: the contraction of
    intersection contours moves more of the cloth, and further, than what is crossed.

    Args:
        nodes: Positions outside the body [m], shape [node_count, 3].
        skin: The body's exposed skin.
        faces: Shape [face_count, 3].
        settings: Iterations and depths.

    Returns:
        Positions [m], no deeper in the body than `limit` or than before; the same array where nothing crosses or
        untangling does not reduce the crossing faces.
    """
    best, least = nodes, len(self_intersections(nodes, faces))
    if not least:
        return nodes
    deepest, moved = max(settings.limit, penetration_depth(nodes, faces, skin)), nodes
    for turn in range(settings.untanglings):
        # further apart, so that they do not meet on the way out
        moved = untangle(moved, faces, UntangleSettings(step=(1 + turn) * settings.step))
        if penetration_depth(moved, faces, skin) > settings.allowed:
            moved = project_outside(moved, skin, faces)
        crossed = len(self_intersections(moved, faces))
        if crossed >= least or penetration_depth(moved, faces, skin) > deepest:
            break
        best, least = moved, crossed
        if not least:
            break
    if least:
        best, least = separate_layers_in_gap(best, faces, skin, deepest, settings)
    if least:
        return best
    limit = max(settings.allowed, penetration_depth(best, faces, skin))
    return _restore_positions(best, nodes, faces, skin, limit, settings.untanglings)


def _restore_positions(
    separated: np.ndarray, before: np.ndarray, faces: np.ndarray, skin: ExposedSurface, limit: float, iterations: int
) -> np.ndarray:
    """Move separated cloth [m], shape [node_count, 3], back towards where it was before as far as its layers let it,
    and without a node or face that gets deeper into the body than a limit [m]."""
    goal = before.copy()
    for _ in range(iterations):
        closer = move_towards(separated, goal, faces)
        moved = (closer != separated).any(axis=1)
        at_nodes, at_faces = np.flatnonzero(moved), faces[moved[faces].any(axis=1)]
        nodes_deep = skin.measure(closer[at_nodes])[0] < -limit
        faces_deep = skin.measure(closer[at_faces].mean(axis=1))[0] < -limit
        if not nodes_deep.any() and not faces_deep.any():
            return closer
        for deep in (at_nodes[nodes_deep], at_faces[faces_deep]):
            goal[deep] = separated[deep]
    return separated


def separate_layers_in_gap(
    nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface, limit: float, settings: SeparationSettings
) -> tuple[np.ndarray, int]:
    """Separate cloth that crosses itself where parts of a body leave too little room; return it and the crossing faces.

    Separating moves one layer deeper than allowed, raising it makes it cross the other: in alternate steps both share
    the room. Steps are short, so that layers end no further apart than necessary.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        faces: Shape [face_count, 3].
        skin: The body's exposed skin.
        limit: Greatest depth in the body [m].
        settings: Iterations and steps.

    Returns:
        Positions no deeper than the limit (the given ones if none cross less), and the number of crossing faces.
    """
    best, least = nodes, len(self_intersections(nodes, faces))
    for _ in range(settings.gap_untanglings):
        nodes = untangle(nodes, faces, UntangleSettings(step=settings.gap_step))
        if penetration_depth(nodes, faces, skin) > limit:
            nodes = limit_penetration(nodes, faces, skin, settings.raised_share * limit)
        crossed = len(self_intersections(nodes, faces))
        if crossed < least and penetration_depth(nodes, faces, skin) <= limit:
            best, least = nodes, crossed
        if not least:
            break
    return best, least
