"""Sheets of cloth and simple bodies to lay them on."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.cloth.bending_friction import BendingFriction
from garmentq.core.cloth.energy import Energy, Inertia
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.cloth.friction import Friction
from garmentq.core.cloth.pins import Pins
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.topology import Topology


def make_sheet(columns: int, rows: int, width: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Return flat points [columns * rows, 2] and counter-clockwise faces of a rectangle of right triangles."""
    u, v = np.meshgrid(np.linspace(0, width, columns), np.linspace(0, height, rows), indexing="ij")
    i = np.arange(columns * rows).reshape(columns, rows)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack([u.ravel(), v.ravel()], axis=1), faces


def make_grid(function, low: float = -0.3, high: float = 0.3, spacing: float = 0.01) -> DistanceGrid:
    """Sample a distance function of points [..., 3] on a cube."""
    axis = np.arange(low, high + spacing / 2, spacing)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    return DistanceGrid.from_values(np.full(3, low), spacing, function(points))


@pytest.fixture(scope="session")
def sheet():
    return make_sheet


@pytest.fixture(scope="session")
def grid_of():
    return make_grid


@pytest.fixture(scope="session")
def cloth() -> Fabric:
    return Fabric("test", H00=300.0, H01=60.0, H11=250.0, H22=100.0, k=2e-5, density=0.15)


@pytest.fixture(scope="session")
def crumpled(sheet):
    """A small sheet, randomly crumpled by 4 mm: topology, nodes, flat points."""
    flat, faces = sheet(7, 6, 0.12, 0.10)
    noise = np.random.default_rng(0).normal(0, 0.004, (len(flat), 3))
    nodes = np.column_stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]]) + noise
    return Topology.from_mesh(faces, flat[faces]), nodes, flat


@pytest.fixture(scope="session")
def everything(crumpled, cloth, grid_of):
    """An energy with every term switched on; the crumpled sheet touches a sphere of 10 cm."""
    topology, nodes, _ = crumpled
    centre = np.array([0.06, -0.1, 0.05])
    grid = grid_of(lambda p: np.linalg.norm(p - centre, axis=-1) - 0.1, -0.15, 0.25)
    rng = np.random.default_rng(1)
    normals = np.tile([0.0, 1.0, 0.0], (len(nodes), 1))
    friction = Friction(nodes + rng.normal(0, 3e-4, nodes.shape), normals, np.full(len(nodes), 0.01), 5e-4)
    pins = Pins(np.array([0, 3]), nodes[[0, 3]] + 0.01, 5.0, (1.0, 0.5, 1.0))
    folds = BendingFriction.at(topology, nodes + rng.normal(0, 3e-4, nodes.shape), 3e-4)
    return Energy(Scene(topology, cloth, grid, pins, bending_friction=folds), friction, Inertia(nodes + 0.01, 400.0))
