"""Turn the parts of a garment beyond its creases, such as falls and lapels, over what is worn."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...garment.creases import find_turned_panels, is_crease
from ...garment.garment import Garment
from ...geometry.geometry import face_normals, unit, vertex_normals
from ...geometry.intersections import self_intersections, undo_crossings

TURN_STEP = np.deg2rad(5.0)
"""Angle by which the turned parts turn at once [rad]: the edge of a lapel 10 cm wide moves by less than 1 cm."""

START_ANGLE = np.deg2rad(75.0)
"""Angle between the turned and the worn part at first [rad]: nearly a right angle, so that it stands out from the
shoulders, but less, so that it falls, and both points of a collar part."""

END_ANGLE = np.deg2rad(50.0)
"""Angle from which it falls by position-based steps [rad]: weight, crease and its outer edge, stretched by now, draw it
down. From 75 degrees on some fell to the wrong side; nearer to the worn part they touched its folds."""

GROWTH_STEP_COUNT = 10
"""Number of steps in which the turned parts grow out of the creases to their width, by less than 1 cm each."""

MIN_OUTWARD_COSINE = 0.3
"""Cosine between the direction in which a turned part stands out and the normal of a face beside the crease, from which
the part is clear of the face: 17 degrees from its plane."""

MAX_OUTWARD_ITERATIONS = 50
"""Largest number of iterations that find a direction in front of all faces around a node."""

OUTWARD_STEP = 0.2
"""Share of a face's normal that each of them adds [1]."""


@dataclass(frozen=True)
class TurnedPart:
    """Describe what is turned over in coordinates about the creases.

    Attributes:
        nodes: Its nodes that are not worn, shape [n].
        crease: The nearest point of the creases to each [m], shape [n, 3].
        height: Its distance from there on the flat panel [m], shape [n, 1].
        outward: Normal of the worn part there, shape [n, 3].
        down: Direction there along the worn part, away from the crease, shape [n, 3].
    """

    nodes: np.ndarray
    crease: np.ndarray
    height: np.ndarray
    outward: np.ndarray
    down: np.ndarray

    def at(self, angle: float, share: float = 1.0) -> np.ndarray:
        """Return positions [m], shape [n, 3], where the part makes an angle [rad] with the worn part at the crease, and
        has a share of its width."""
        leaning = np.sin(angle) * self.outward + np.cos(angle) * self.down
        return np.asarray(self.crease + share * self.height * leaning)


def turn_over(garment: Garment, nodes: np.ndarray, worn: Garment, numbers: np.ndarray) -> np.ndarray:
    """Turn panels over along the creases, and return the nodes of the whole garment [m], shape [node_count, 3].

    At first they grow out of the creases at `START_ANGLE`, so that they stand out as a ruff does. Then they turn
    towards the worn part to `END_ANGLE`. A node that would cross other cloth stops. The lengths along the crease are
    not kept.

    Args:
        garment: The whole garment.
        nodes: Positions of the worn part's nodes [m], shape [worn_count, 3].
        worn: The worn part.
        numbers: The number in the garment of each of its nodes.
    """
    placed = np.zeros((len(garment.nodes), 3))
    placed[numbers] = nodes
    part = _find_part(garment, placed, worn, numbers)
    shares = np.arange(1, GROWTH_STEP_COUNT + 1) / GROWTH_STEP_COUNT
    angles = np.arange(START_ANGLE, END_ANGLE, -TURN_STEP)[1:]
    path = [part.at(START_ANGLE, share) for share in shares] + [part.at(angle) for angle in angles]
    placed[part.nodes] = path[0]
    crossed = self_intersections(placed, garment.faces)
    for before, after in pairwise(path):
        start = placed.copy()
        placed[part.nodes] += after - before
        crossed = undo_crossings(placed, start, garment.faces, crossed)
    return placed


def _find_part(garment: Garment, placed: np.ndarray, worn: Garment, numbers: np.ndarray) -> TurnedPart:
    """Return the turned part of a garment whose worn nodes are placed [m], shape [node_count, 3].

    Its direction along the worn part is square to the crease on each panel, so that two ends of creases at one node,
    such as those at both points of a collar, part there.
    """
    count, turned = len(garment.nodes), find_turned_panels(garment.pattern)
    normals = np.zeros((count, 3))
    normals[numbers] = _outward_vectors(placed[numbers], worn.faces)
    total, parts = np.zeros((count, 10)), np.zeros(count)
    for i, panel in enumerate(garment.pattern.panels):
        lines = [
            line for ref, line in garment.edge_uv.items() if ref.panel == panel.name and is_crease(garment.pattern, ref)
        ]
        if panel.name not in turned or not lines:
            continue
        starts, ends = (np.concatenate([line[cut] for line in lines]) for cut in (slice(0, -1), slice(1, None)))
        own = np.flatnonzero(garment.panel_of_uv == i)
        segment, share, height = _project(garment.uv[own], garment.uv[starts], garment.uv[ends])
        chords = unit(placed[garment.uv_node[ends]] - placed[garment.uv_node[starts]])
        along = np.zeros((len(garment.uv), 3))
        np.add.at(along, starts, chords)
        np.add.at(along, ends, chords)
        of_vertex = normals[garment.uv_node]
        frame = (placed[garment.uv_node], of_vertex, unit(np.cross(unit(along), of_vertex)))
        at = [(1.0 - share) * field[starts[segment]] + share * field[ends[segment]] for field in frame]
        np.add.at(total, garment.uv_node[own], np.hstack([*at, height]))
        np.add.at(parts, garment.uv_node[own], 1.0)
    parts[numbers] = 0.0
    free = np.flatnonzero(parts)
    crease, outward, down, height = np.split(total[free] / parts[free, None], [3, 6, 9], axis=1)
    return TurnedPart(free, crease, height, unit(outward), unit(down))


def _outward_vectors(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return a unit vector at each node, shape [n, 3], that is in front of all faces around it if one is found.

    The mean normal may be behind a face where coarse cloth is buckled. The normal of the face that it is furthest
    behind is then added to it, again and again: the perceptron's search for a vector in front of several planes.
    """
    found, normals = vertex_normals(nodes, faces), face_normals(nodes, faces)[0]
    corner, face = faces.ravel(), np.repeat(np.arange(len(faces)), 3)
    for _ in range(MAX_OUTWARD_ITERATIONS):
        ahead = (found[corner] * normals[face]).sum(axis=1)
        order = np.lexsort((ahead, corner))
        first = order[np.unique(corner[order], return_index=True)[1]]  # the lowest of each node
        worst = first[ahead[first] < MIN_OUTWARD_COSINE]
        if not len(worst):
            break
        found[corner[worst]] = unit(found[corner[worst]] + OUTWARD_STEP * normals[face[worst]])
    return found


def _project(points: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the nearest of some segments to each point in the plane [m]: its number, shape [n], the share of its length
    at the nearest point, and the distance from there [m], shape [n, 1]."""
    along, offset = ends - starts, points[:, None] - starts
    share = np.clip((offset * along).sum(2) / (along**2).sum(1), 0.0, 1.0)
    distance = np.linalg.norm(offset - share[..., None] * along, axis=2)
    nearest = distance.argmin(axis=1)
    row = np.arange(len(points))
    return nearest, share[row, nearest, None], distance[row, nearest, None]
