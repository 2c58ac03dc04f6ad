"""Place the mesh of an edited pattern over the present drape, also where panels were cut, joined or given points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.rigid import plane_rotation
from .control import update_flat_mesh
from .curves import chord
from .garment import Garment
from .meshing import corner_angles
from .orientation import place_points
from .pattern import Panel, Pattern
from .resampling import locate
from .sewing import mesh_pattern

MIN_MOVED_TRIANGLE_ANGLE = np.radians(15.0)
"""Smallest triangle angle [rad] at which a mesh that follows moved points is kept; new meshes have 20 to 30 degrees."""

SAME_PLACE_TOLERANCE = 0.01
"""Mean distance [m] between the placed control points of a panel and those of another one, up to which it was cut out
of that panel: a cut piece keeps its axes and its placement."""

MAX_EXTRAPOLATION_WEIGHT = 20.0
"""Largest barycentric weight [1] of a point beyond the present cloth. At so many triangles' distance, 40 cm where they
are of 2 cm, its position is unknown."""


def transfer_nodes(garment: Garment, pattern: Pattern) -> Garment | None:
    """Return an edited pattern's mesh with its nodes where the present garment has the same cloth.

    Where only points and curves changed, the mesh follows them (`update_flat_mesh`). Otherwise the pattern is meshed
    anew, and each node is placed where the present mesh has its flat point: in the panel of its name or the one that it
    was cut out of, together with removed panels that were sewn to that one, aligned along their seam. Beyond the
    present outline the nearest triangle is extrapolated.

    Args:
        garment: The present pattern's mesh, draped.
        pattern: The edited pattern.

    Returns:
        The mesh; None where the source of a panel or a part of one is unknown.

    Raises:
        MeshTooCoarse: where the pattern cannot be meshed.
    """
    if _has_same_topology(garment.pattern, pattern):
        moved = update_flat_mesh(garment, pattern)
        if corner_angles(moved.uv, moved.uv_faces).min() > MIN_MOVED_TRIANGLE_ANGLE:
            return moved
    old = {panel.name: index for index, panel in enumerate(garment.pattern.panels)}
    removed = set(old) - {panel.name for panel in pattern.panels}
    bases = [_find_base(garment.pattern, panel) for panel in pattern.panels]
    if None in bases:
        return None
    mesh = mesh_pattern(pattern, len(garment.nodes))
    found = np.zeros((len(mesh.uv), 3))
    for index, base in enumerate(bases):
        assert base is not None
        points = np.flatnonzero(mesh.panel_of_uv == index)
        flat, faces = _arrange_flat_panels(garment, _find_merged_panels(garment.pattern, base, removed))
        corner, weight = locate(flat, faces, mesh.uv[points], is_within=False)
        if np.abs(weight).max() > MAX_EXTRAPOLATION_WEIGHT:
            return None
        found[points] = np.einsum("nk,nkd->nd", weight, garment.nodes[garment.uv_node[corner]])
    count = len(mesh.nodes)
    shares = np.bincount(mesh.uv_node, minlength=count)
    return mesh.at(np.stack([np.bincount(mesh.uv_node, found[:, k], count) / shares for k in range(3)], axis=1))


@dataclass(frozen=True)
class Motion:
    """Describe a rigid motion of the plane: p -> p @ rotation.T + shift."""

    rotation: np.ndarray
    shift: np.ndarray

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Return points [m] after the motion, shape [n, 2]."""
        return np.asarray(points @ self.rotation.T + self.shift)


def _has_same_topology(one: Pattern, other: Pattern) -> bool:
    """Return whether two patterns have the same panels, numbers of control points and seams."""
    panels = [[(panel.name, len(panel.points)) for panel in pattern.panels] for pattern in (one, other)]
    seams = [[(seam.a, seam.b) for seam in pattern.seams] for pattern in (one, other)]
    return panels[0] == panels[1] and seams[0] == seams[1]


def _find_base(pattern: Pattern, panel: Panel) -> str | None:
    """Return the name of the panel that a panel is, or was cut out of; None where there is none."""
    if any(one.name == panel.name for one in pattern.panels):
        return panel.name
    placed = place_points(panel, panel.points)
    best = min(pattern.panels, key=lambda one: _placement_distance(one, panel, placed))
    return best.name if _placement_distance(best, panel, placed) <= SAME_PLACE_TOLERANCE else None


def _placement_distance(one: Panel, panel: Panel, placed: np.ndarray) -> float:
    """Return the mean distance [m] between a panel's placed points and the same points placed by another panel's
    axes."""
    return float(np.linalg.norm(place_points(one, panel.points) - placed, axis=1).mean())


def _find_merged_panels(pattern: Pattern, base: str, removed: set[str]) -> dict[str, Motion]:
    """Return the panels whose cloth a panel may have now, each with the motion into that panel's axes: the panel
    itself, and removed panels that were sewn to it or to one of these."""
    found = {base: Motion(np.eye(2), np.zeros(2))}
    grown = True
    while grown:
        grown = False
        for seam in pattern.seams:
            for one, two in ((seam.a, seam.b), (seam.b, seam.a)):
                if one.panel in found and two.panel in removed and two.panel not in found:
                    ends = found[one.panel].apply(np.stack(chord(pattern.panel(one.panel), one.edge)))
                    found[two.panel] = align_chords(np.stack(chord(pattern.panel(two.panel), two.edge))[::-1], ends)
                    grown = True
    return found


def align_chords(chord_of: np.ndarray, ends: np.ndarray) -> Motion:
    """Return the motion that aligns a chord to another one, middle on middle, shape [2, 2] each."""
    one, other = (line[1] - line[0] for line in (chord_of, ends))
    angle = np.arctan2(other[1], other[0]) - np.arctan2(one[1], one[0])
    turn = plane_rotation(angle)
    return Motion(turn, ends.mean(axis=0) - turn @ chord_of.mean(axis=0))


def _arrange_flat_panels(garment: Garment, parts: dict[str, Motion]) -> tuple[np.ndarray, np.ndarray]:
    """Return all flat vertices [m], those of some panels moved, and the triangles of these panels."""
    flat, chosen = garment.uv.copy(), np.zeros(len(garment.uv_faces), bool)
    for index, panel in enumerate(garment.pattern.panels):
        if panel.name in parts:
            in_panel = garment.panel_of_uv == index
            flat[in_panel] = parts[panel.name].apply(garment.uv[in_panel])
            chosen |= garment.panel_of_face == index
    return flat, garment.uv_faces[chosen]
