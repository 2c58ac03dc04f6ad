"""Every template is carried into the built-in body's poses, whole and outside it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import product

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.body.projection import project_outside
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import list_templates, load_template
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.dress import dress
from garmentq.core.recover.drape.layer_contact import LayerContact
from garmentq.core.recover.drape.pbd import DistanceConstraints, PbdState, build_distance_constraints, simulate_pbd
from garmentq.core.recover.drape.pose_path import PosePath, pose_cloth
from garmentq.core.recover.drape.waist import waist_loop
from sized_template import size_template

NODES = 350
"""Edges of 5 cm: the coarsest at which a sleeve still is a tube."""

STATURES = {"female": "builtin:female,height=1.70", "male": "builtin:male"}

POSES = ("A", "stride", "arms-down", "seated")


@cache
def wearer(gender: str, pose: str) -> tuple[Body, DistanceGrid]:
    """Return the built-in body in a pose with its distance grid."""
    body = builtin_body(f"{STATURES[gender]},pose={pose}")
    return body, DistanceGrid.from_mesh(body.vertices, body.faces)


@cache
def way(gender: str, pose: str) -> PosePath:
    """Return a body's frames into a pose."""
    return PosePath.of(wearer(gender, pose)[0], outside(gender, pose))


@cache
def worn(name: str, gender: str) -> tuple[Garment, DistanceConstraints, np.ndarray | None, np.ndarray]:
    """Dress a body in its T-pose: the templates were drafted for her; for him they are drafted to his measures."""
    body, grid = wearer(gender, "T")
    garment = mesh_pattern(load_template(name) if gender == "female" else size_template(name, body), NODES)
    threads = build_distance_constraints(garment)
    return garment, threads, waist_loop(garment), dress(garment, body, grid, threads=threads)


def tangled(nodes: np.ndarray, garment: Garment) -> int:
    """Count the faces that cross another."""
    return len(self_intersections(nodes, garment.faces))


NAMES = [info.name for info in list_templates()]


def choose_cases() -> Iterator[object]:
    """Yield each template in each pose on each body; in the suite each template in one, poses and bodies in turn.

    The others are nightly. So every template, pose and body occurs, and each pose on both bodies.
    """
    bodies = sorted(STATURES)
    for (row, name), gender, pose in product(enumerate(NAMES), bodies, POSES):
        turn = POSES[row % len(POSES)], bodies[(row // len(POSES) + row) % len(bodies)]
        yield pytest.param(name, gender, pose, marks=() if (pose, gender) == turn else pytest.mark.nightly)


def choose_bodies() -> Iterator[object]:
    """Yield each template on each body; in the suite on one, the bodies in turn, and at night on the other."""
    for (row, name), (column, gender) in product(enumerate(NAMES), enumerate(sorted(STATURES))):
        yield pytest.param(name, gender, marks=() if row % 2 == column else pytest.mark.nightly)


@cache
def outside(gender: str, pose: str) -> ExposedSurface:
    """Return the outside of a body in a pose."""
    return ExposedSurface.of(wearer(gender, pose)[0])


def depth(nodes: np.ndarray, garment: Garment, skin: ExposedSurface) -> float:
    """Return how far the deepest node or face's middle has to go to leave a body [m]."""
    return -float(skin.measure(np.concatenate([nodes, nodes[garment.faces].mean(axis=1)]))[0].min())


def at_rest(velocity: np.ndarray) -> bool:
    """Check that nine nodes of ten are slower than 3 cm/s, half than 1 cm/s: what falls is at 1 m/s."""
    speed = np.linalg.norm(velocity, axis=1)
    return bool(np.median(speed) < 0.01 and np.quantile(speed, 0.9) < 0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "gender"), list(choose_bodies()))
def test_template_hangs_in_the_t_pose(name: str, gender: str) -> None:
    """Breaks if dressing crumples a fork through itself, leaves both seams of a leg on one side of it, or swings.

    Nodes are out of the body as they hang; the middles of 5 cm edged faces that span a bust are pushed out at the end.
    """
    garment, threads, waist, nodes = worn(name, gender)
    skin, lookup = outside(gender, "T"), wearer(gender, "T")[1]
    start = PbdState.at_rest(nodes)
    state = simulate_pbd(threads, start, lookup, 6, gravity=9.81, pins=waist, layers=LayerContact())
    # let go from rest for a tenth of a second: what nothing holds falls at 1 m/s by then
    assert at_rest(state.velocities)
    assert tangled(nodes, garment) == 0
    assert skin.measure(nodes)[0].min() >= -1e-3
    nodes = project_outside(nodes, skin, garment.faces)
    assert tangled(nodes, garment) == 0
    assert depth(nodes, garment, skin) <= 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(("name", "gender", "pose"), list(choose_cases()))
def test_template_hangs_in_every_pose(name: str, gender: str, pose: str) -> None:
    """Breaks if the way into a pose pushes a garment through itself, through the body, or leaves it swinging.

    Depth is that of the way out past all parts of the body, as deep as that to the nearest skin or deeper.
    """
    garment, threads, waist, nodes = worn(name, gender)
    _, grid = wearer(gender, pose)
    nodes, velocity = pose_cloth(threads, nodes, way(gender, pose), grid, pins=waist)
    assert tangled(nodes, garment) == 0
    assert depth(nodes, garment, way(gender, pose).skin) <= 1e-3
    assert at_rest(velocity)
