"""A small recovery whose truth is known: a tube of two panels around a cylinder."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.garment.meshes import Meshes
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.recover.recovery import Recovery
from garmentq.core.run.report import ResultReport
from garmentq.core.scan.contours.target import Contour, Target
from garmentq.core.scan.scan import Scan
from hypothesis import HealthCheck, settings

RADIUS, HEIGHT = 0.15, 0.30

settings.register_profile("no-clock", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("no-clock")  # whether examples are drawn fast enough depends on what else the machine does

SERVED = ("service", "chaos", "workers", "cli", "api", "pages")
"""Folders whose tests start servers and mostly wait for them, in the order in which they run."""

LAST = ("garment", "judge", "pieces", "contours", "geometry", "motion", "training", "texture", "scan")
"""Folders that compile little of the simulator, with a third of all tests, as `SERVED` has."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run what computes, then what is served, then the rest, each folder in its order.

    Each of three processes begins with a third of its own. While the first compiles the simulator, a minute or two
    after a fresh installation, the second waits for servers, and finds it compiled.
    """
    ranks = {name: 1 + rank for rank, name in enumerate(SERVED)} | dict.fromkeys(LAST, 1 + len(SERVED))
    items.sort(key=lambda item: ranks.get(item.path.parent.name, 0))


def make_tube_pattern(width: float = np.pi * RADIUS, height: float = HEIGHT, names=("front", "back")) -> Pattern:
    """Draw two rectangles that are sewn into a tube; edges: hem, right, waist, left."""
    points = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    edges = (Edge(contour="hem"), Edge(), Edge(contour="waist"), Edge())
    panels = tuple(Panel(name, points, edges) for name in names)
    seams = tuple(Seam(EdgeRef(names[0], a), EdgeRef(names[1], b)) for a, b in ((1, 3), (3, 1)))
    return Pattern("tube", panels, seams, category="skirt")


def make_tube(pattern: Pattern, edge_length: float = 0.02, radius: float = RADIUS):
    """Mesh the pattern and roll it around the y axis: the front panel on +z."""
    garment = mesh_pattern(pattern, edge_length=edge_length)
    uv = garment.uv / garment.uv.max(axis=0)
    angle = np.pi * (uv[:, 0] + garment.panel_of_uv) - np.pi / 2.0
    nodes = np.zeros((len(garment.nodes), 3))
    nodes[garment.uv_node] = np.stack([radius * np.sin(angle), 0.8 + garment.uv[:, 1], radius * np.cos(angle)], axis=1)
    return garment.at(nodes, contours=tube_contours(nodes))


def tube_contours(nodes: np.ndarray) -> tuple[Contour, ...]:
    """Name both rims of a tube."""
    rims = []
    for name, y in (("hem", nodes[:, 1].min()), ("waist", nodes[:, 1].max())):
        rim = np.flatnonzero(np.abs(nodes[:, 1] - y) < 1e-9)
        rims.append(Contour(name, rim[np.argsort(np.arctan2(nodes[rim, 0], nodes[rim, 2]))], 2 * np.pi * RADIUS))
    return tuple(rims)


def make_body(vertices: np.ndarray, faces: np.ndarray) -> Body:
    """Return a body that is only a mesh, with joints along the y axis."""
    joints = np.stack([np.zeros(24), np.linspace(0.0, 1.7, 24), np.zeros(24)], axis=1)
    weights = np.zeros((len(vertices), len(JOINTS)))
    weights[:, 0] = 1.0
    pose = np.tile(np.eye(4), (24, 1, 1))
    return Body(vertices, faces, joints, weights, pose, vertices, faces, joints, weights, np.eye(3), source="mesh:post")


@pytest.fixture(scope="session")
def tube_pattern():
    """Return the maker of tube patterns."""
    return make_tube_pattern


@pytest.fixture(scope="session")
def tube():
    """Return the maker of rolled tubes."""
    return make_tube


@pytest.fixture(scope="session")
def bare_body():
    """Return the maker of bodies from meshes."""
    return make_body


@pytest.fixture(scope="session")
def tube_recovery():
    """Return the maker of finished recoveries of a tube; keyword arguments replace its fields."""
    import trimesh
    from garmentq.core.body.exposed import ExposedSurface
    from garmentq.core.judge.fit import Reference, measure_fit
    from garmentq.core.judge.gates import evaluate_gates
    from garmentq.core.judge.patterns import measure_seams

    @functools.cache
    def base(names: tuple[str, str]) -> Recovery:
        garment = make_tube(make_tube_pattern(names=names))
        post = trimesh.creation.cylinder(radius=0.13, height=1.2, sections=48)
        body = make_body(post.vertices[:, [1, 2, 0]] + [0.0, 0.95, 0.0], np.array(post.faces))
        skin = ExposedSurface.of(body)
        swell = 1.0 + 0.02 * np.sin(8.0 * np.arctan2(garment.nodes[:, 0], garment.nodes[:, 2]))
        detail = garment.nodes * np.stack([swell, np.ones_like(swell), swell], axis=1)
        target = Target(garment.nodes, garment.faces, garment.nodes, garment.contours, (), "skirt")
        graded, faces, contours = garment.nodes * 1.01, garment.faces, garment.contours
        meshes = Meshes(graded, detail)
        truth = Reference(TriangleSurface(garment.nodes, faces), contours, skin, samples=2000)
        metrics = measure_fit(garment, meshes, truth)
        metrics |= measure_seams(garment.pattern)
        values = {
            "scan": Scan(garment.nodes, faces, name="tube"),
            "body": body,
            "target": target,
            "template": "skirt",
            "pattern": garment.pattern,
            "fabric": Fabric("cotton", 500.0, 100.0, 500.0, 100.0, 1e-5, 0.12, title="cotton, 120 g/m2"),
            "garment": garment,
            "meshes": meshes,
            "report": ResultReport(
                metrics,
                evaluate_gates(metrics),
                ("The scan's hem was frayed.",),
                {"scan": 0.2, "deform": 3.4},
                3.6,
                321.0,
                {"seed": 0},
            ),
        }
        return Recovery(**values)

    def make(panel_names: tuple[str, str] = ("front", "back"), **changes) -> Recovery:
        found, reported = base(panel_names), {field.name for field in dataclasses.fields(ResultReport)}
        report = dataclasses.replace(found.report, **{name: changes.pop(name) for name in reported & set(changes)})
        return dataclasses.replace(found, report=report, **changes)

    return make
