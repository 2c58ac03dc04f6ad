"""What cloth knows of itself between searches: pairs found around what moved, and ways looked over afterwards."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.collision.closest import EDGE_EDGE, NODE_FACE, closest_weights, pair_distance
from garmentq.core.cloth.collision.near_pairs import find_near_pairs
from garmentq.core.cloth.collision.patch_pairs import find_close_patches, remove_mean_motion
from garmentq.core.cloth.collision.path_check import verify_pairs_on_path
from garmentq.core.cloth.collision.self_contact import SelfContact
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.settings import SolveSettings
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.intersections import self_intersections


def lay_two(sheet, gap: float) -> tuple[Topology, np.ndarray]:
    """Return two level sheets, the upper one smaller and so with edges of its own, a gap [m] apart."""
    wide, under = sheet(8, 8, 0.12, 0.12)
    small, over = sheet(6, 6, 0.07, 0.08)
    nodes = np.concatenate([
        np.column_stack([wide[:, 0], np.zeros(len(wide)), -wide[:, 1]]),
        np.column_stack([small[:, 0] + 0.02, np.full(len(small), gap), -small[:, 1] - 0.02]),
    ])  # fmt: skip
    return Topology.from_mesh(
        np.concatenate([under, over + len(wide)]), np.concatenate([wide[under], small[over]])
    ), nodes


def list_touching(cloth: SelfContact, nodes: np.ndarray, within: float = 2e-3) -> set[tuple[int, ...]]:
    """Return all pairs within a distance [m], each tested on its own."""
    weights, rates, vector = np.zeros(4), np.zeros((2, 4)), np.zeros(3)
    faces, edges = cloth.faces.tolist(), cloth.edges.tolist()
    groups = [(NODE_FACE, (i, *f)) for i in range(len(nodes)) for f in faces if i not in f]
    groups += [(EDGE_EDGE, (*a, *b)) for n, a in enumerate(edges) for b in edges[n + 1 :] if not {*a} & {*b}]
    found = set()
    for kind, pair in groups:
        closest_weights(nodes, np.array(pair), kind, weights, rates)
        if pair_distance(nodes, np.array(pair), weights, vector) < within:
            found.add((kind, *pair))
    return found


def name_pairs(near) -> list[tuple[int, ...]]:
    """Return kind and nodes of near pairs."""
    return [(int(kind), *pair.tolist()) for kind, pair in zip(near.pairs.kinds, near.pairs.nodes, strict=True)]


def test_a_search_around_what_moved_finds_what_a_full_one_would(sheet, monkeypatch):
    """A pair of moved and resting cloth left out, kept twice, or found too near for what still drifts breaks this."""
    many = 0.5
    monkeypatch.setattr("garmentq.core.cloth.collision.path_check.MAX_MOVED_NODE_SHARE", many)
    topology, nodes = lay_two(sheet, 6e-3)
    cloth = SelfContact.of(topology)
    rng = np.random.default_rng(2)
    near, known = find_near_pairs(cloth, nodes), set()
    for turn in range(3):
        corner = np.linalg.norm(nodes[:, [0, 2]] - nodes[-1 - turn, [0, 2]], axis=1) < 0.03
        lower = corner & (np.arange(len(nodes)) >= 64)
        assert 0.0 < lower.mean() < many
        drift = 0.5 * cloth.margin * rng.uniform(-1, 1, nodes.shape) / np.sqrt(3.0)
        end = nodes + drift - np.where(lower[:, None], [[0.0, 4.2e-3 - 4e-4 * turn, 0.0]], 0.0)
        near, _ = verify_pairs_on_path(cloth, np.stack([nodes, end]), replace(near, frozen=True))
        names = name_pairs(near)
        assert len(names) == len(set(names)) and len(set(near.keys.tolist())) == len(names)
        nodes = end
        known = list_touching(cloth, nodes + near.margin * rng.uniform(-0.2, 0.2, nodes.shape) / np.sqrt(3.0))
        assert known <= set(names)
    assert len(known) > 20


def roll(sheet) -> tuple[Topology, np.ndarray]:
    """Return a tube, 60 mm long and 96 mm around, sewn along one line, and where its nodes lie when flat [m]."""
    flat, faces = sheet(17, 11, 0.096, 0.06)
    last = np.isclose(flat[:, 0], 0.096)
    first = np.array([np.argmin(np.linalg.norm(flat - [0.0, y], axis=1)) for y in flat[last, 1]])
    number = np.cumsum(~last) - 1
    number[last] = number[first]
    return Topology.from_mesh(number[faces], flat[faces]), flat[~last]


def test_patches_that_are_passed_over_hold_nothing_near(sheet):
    """Bent, pressed, crumpled or sewn cloth that passes for flat, or a bend between two places, breaks this."""
    topology, flat = roll(sheet)
    cloth, rng = SelfContact.of(topology), np.random.default_rng(8)
    count, searched = len(cloth.patches.joined), []
    angle, radius = 2.0 * np.pi * flat[:, 0] / 0.096, 0.096 / (2.0 * np.pi)
    places = [
        np.column_stack([stretch * radius * np.cos(angle), flat[:, 1], press * radius * np.sin(angle)])
        + rng.normal(0.0, noise, (len(flat), 3))
        for stretch, press, noise in ((1.0, 1.0, 0.0), (1.3, 0.5, 2e-4), (1.5, 0.06, 2e-4), (1.5, 0.06, 1.5e-3))
    ]
    touching = 0
    for nodes in places:
        known = list_touching(cloth, nodes, float(cloth.reach.max()) + 2.0 * cloth.margin)
        found = name_pairs(find_near_pairs(cloth, nodes))
        assert set(found) == known and len(found) == len(known)
        path, spans = remove_mean_motion(nodes[None])
        close = find_close_patches(cloth.patches, path, spans, float(cloth.reach.max()) + 2.0 * cloth.margin, None)
        searched.append(len(close) / count)
    assert searched[0] < 0.6 < searched[-1]
    for start, end in itertools.pairwise(places):
        found = set(name_pairs(find_near_pairs(cloth, start, end)))
        for t in (0.0, 0.35, 0.7, 1.0):
            known = list_touching(cloth, start + t * (end - start))
            touching += len(known)
            assert known <= found
    assert touching > 500


def test_a_way_holds_as_far_as_nothing_new_came_near(sheet):
    """A pair that came within reach on the way and is not told, or one that was watched and is, breaks this."""
    topology, nodes = lay_two(sheet, 12e-3)
    cloth = SelfContact.of(topology)
    upper = np.arange(len(nodes)) >= 64
    way = [nodes - np.where(upper[:, None], [[0.0, fall, 0.0]], 0.0) for fall in (0.0, 3e-3, 6e-3, 10.5e-3, 11e-3)]
    near, last = verify_pairs_on_path(cloth, np.stack(way), find_near_pairs(cloth, nodes))
    assert last == 2
    assert list_touching(cloth, way[3]) <= set(name_pairs(near))
    again, last = verify_pairs_on_path(cloth, np.stack(way[2:]), replace(near, frozen=True))
    assert last == 2 and list_touching(cloth, way[4]) <= set(name_pairs(again))
    # there and back between two places is not at rest in between
    away = [way[0], way[3], way[0]]
    assert verify_pairs_on_path(cloth, np.stack(away), find_near_pairs(cloth, nodes))[1] == 0


def test_a_leg_that_outruns_what_it_watched_still_crosses_nothing(sheet, cloth):
    """A leg that is not cut back to before the touch breaks this: the sheet would be through the other in one step."""
    topology, nodes = lay_two(sheet, 0.03)
    held = np.arange(64)
    scene = Scene(topology, cloth, pins=Pins(held, nodes[held]), self_contact=SelfContact.of(topology))
    rest = equilibrium(scene, nodes, settings=SolveSettings(max_iterations=40))
    assert len(self_intersections(rest.nodes, topology.faces)) == 0
    assert rest.nodes[64:, 1].mean() > 0.5e-3
    free = equilibrium(replace(scene, self_contact=None), nodes, settings=SolveSettings(max_iterations=3))
    assert free.nodes[64:, 1].mean() < -0.05
    energy = Energy(scene)
    watched = energy.freeze(nodes)
    assert watched.near.frozen and not watched.verify_pairs(nodes[None])[0].near.frozen


def test_pins_that_hold_cloth_crossed_let_it_go(sheet, cloth):
    """A pinned contour that crosses itself and is held to the end, or pins let go elsewhere, breaks this."""
    flat, faces = sheet(13, 13, 0.12, 0.12)
    count = len(flat)
    topology = Topology.from_mesh(np.concatenate([faces, faces + count]), np.concatenate([flat[faces]] * 2))
    upper = flat * 0.97 + 0.0017
    away = np.linalg.norm(upper - [0.0, 0.06], axis=1)
    nodes = np.concatenate([
        np.column_stack([flat[:, 0], np.zeros(count), -flat[:, 1]]),
        np.column_stack([upper[:, 0], 4e-3 - 8e-3 * np.exp(-((away / 0.02) ** 2)), -upper[:, 1]]),
    ])  # fmt: skip
    border = np.flatnonzero(np.tile(flat[:, 0] == 0.0, 2))
    scene = Scene(
        topology,
        cloth,
        pins=Pins(border, nodes[border]),
        gravity=(0.0, 0.0, 0.0),
        self_contact=SelfContact.of(topology),
    )
    crossed = topology.faces[self_intersections(nodes, topology.faces)]
    assert np.isin(crossed, border).any()
    rest = equilibrium(scene, nodes, settings=SolveSettings(max_iterations=2))
    assert len(self_intersections(rest.nodes, topology.faces)) == 0
    still = np.setdiff1d(border, crossed)
    assert len(still) > 10 and rest.nodes[still] == pytest.approx(nodes[still], abs=1e-12)
