"""Cloth that crosses itself is laid smooth, and layers leave a body together."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.advection import advect_outside
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.intersections import self_intersections, undo_crossings
from garmentq.core.recover.drape.layers import find_layer_constraints
from garmentq.core.recover.drape.leg_alignment import align_legs
from garmentq.core.recover.drape.pbd import DistanceConstraints, PbdSettings
from garmentq.core.recover.drape.unfolding import unfold_crossings


def lattice(count: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a level square sheet of count x count nodes."""
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    nodes = np.column_stack([step * i.ravel(), np.zeros(i.size), step * j.ravel()])
    at = np.arange(count * count).reshape(count, count)
    a, b, c, d = (at[s].ravel() for s in (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]))
    return nodes, np.concatenate([np.column_stack([a, c, b]), np.column_stack([a, d, c])])


def threads_of(nodes: np.ndarray, faces: np.ndarray) -> DistanceConstraints:
    """Return the edges of a mesh at rest as constraints."""
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    lengths = np.linalg.norm(nodes[edges[:, 0]] - nodes[edges[:, 1]], axis=1)
    return DistanceConstraints(edges, lengths, np.ones(len(edges)), np.ones(len(nodes)), faces, edges)


class Floor:
    """A body that fills everything below y = 0."""

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return heights [m] and the direction upwards."""
        return points[:, 1], np.tile([0.0, 1.0, 0.0], (len(points), 1))


def test_a_crumple_is_laid_smooth() -> None:
    """Breaks where a patch stays crossed, loses its size, or cloth far from it moves."""
    flat, faces = lattice(15, 0.02)
    flat[:, 1] = 0.05
    threads, nodes = threads_of(flat, faces), flat.copy()
    middle = np.linalg.norm(flat[:, [0, 2]] - 0.14, axis=1) < 0.045
    nodes[middle] += np.random.default_rng(0).normal(0.0, 0.03, (middle.sum(), 3))
    assert len(self_intersections(nodes, faces)) > 10
    found = unfold_crossings(threads, nodes, Floor(), settings=PbdSettings())
    assert len(self_intersections(found, faces)) == 0
    ends = found[threads.ends]
    assert np.abs(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) / threads.lengths - 1.0).max() < 0.1
    assert np.linalg.norm(found - flat, axis=1)[np.abs(flat[:, [0, 2]] - 0.14).max(axis=1) > 0.13].max() < 2e-3
    assert unfold_crossings(threads, flat, Floor(), settings=PbdSettings()) is flat


def test_layers_leave_a_body_together() -> None:
    """Breaks where the lower of two layers is pushed through the upper one, which is not in the body."""
    flat, faces = lattice(9, 0.04)
    nodes = np.concatenate([flat, flat])
    nodes[: len(flat), 1] = -0.02 * np.exp(-((flat[:, [0, 2]] - 0.16) ** 2).sum(axis=1) / 0.01) + 1e-3
    nodes[len(flat) :, 1] = nodes[: len(flat), 1] + 2e-3
    both = np.concatenate([faces, faces + len(flat)])
    found = advect_outside(nodes, both, Floor(), threads_of(nodes, both).mean_edge, 40)
    middles = found[both].mean(axis=1)
    assert nodes[:, 1].min() < -0.015 and found[:, 1].min() >= 0.0 and middles[:, 1].min() >= 0.0
    assert len(self_intersections(found, both)) == 0
    assert (found[len(flat) :, 1] - found[: len(flat), 1]).min() > 0.0


def test_a_jammed_bundle_still_moves() -> None:
    """Breaks where steps that cross are undone altogether, or cut to more than the room there is."""
    flat, faces = lattice(4, 0.05)
    nodes = np.concatenate([flat, flat])
    nodes[len(flat) :, 1] = 2e-3
    both = np.concatenate([faces, faces + len(flat)])
    threads = threads_of(nodes, both)
    room = find_layer_constraints(nodes, both, threads.edges, np.zeros(0, np.int64), 2e-3, 10e-3).room(nodes, 10e-3)
    np.testing.assert_allclose(room, 0.9e-3)
    rising = (np.arange(len(nodes)) < len(flat)) & (nodes[:, 0] > 0.07)
    moved = nodes + rising[:, None] * [0.0, 0.05, 0.0]
    assert len(self_intersections(moved, both))
    left = undo_crossings(moved, nodes, both, np.zeros(0, np.int64), room)
    assert len(left) == 0 and np.abs(moved - nodes).max() >= 0.9e-3 - 1e-12


@pytest.mark.parametrize("across", [0.01, 0.09])
def test_legs_are_laid_along_the_wearers(across: float) -> None:
    """Breaks where straight legs stay upright on legs that stand apart, though each reaches across the middle by less
    than half of it, or a skirt is torn in two."""
    body = builtin_body("builtin:male,pose=T")
    flat, faces = lattice(12, 0.02)
    leg = np.column_stack([flat[:, 0] - across, 0.1 + 3.0 * flat[:, 2], np.zeros(len(flat))])
    left, right = leg, leg * [-1.0, 1.0, 1.0]
    nodes, both = np.concatenate([left, right]), np.concatenate([faces, faces + len(flat)])
    nodes[:, 0] += body.joint("pelvis")[0]
    spread = align_legs(nodes, both, body)
    hem = nodes[:, 1] == nodes[:, 1].min()
    ankle, knee = body.joint("left_ankle"), body.joint("left_knee")
    slope = (ankle[0] - knee[0]) / (knee[1] - ankle[1])
    moved = (spread - nodes)[hem & (np.arange(len(nodes)) < len(flat)), 0]
    assert slope > 0.05 and (moved > 0.5 * slope * (knee[1] - ankle[1])).all()
    np.testing.assert_array_equal(spread[:, 1:], nodes[:, 1:])
    skirt = np.column_stack([4.0 * (flat[:, 0] - 0.11), leg[:, 1], leg[:, 2]])
    np.testing.assert_array_equal(align_legs(skirt, faces, body), skirt)
    slit = np.concatenate([skirt, skirt * [-1.0, 1.0, 1.0] + [0.0, 0.0, 0.02]])
    np.testing.assert_array_equal(align_legs(slit, both, body), slit)
