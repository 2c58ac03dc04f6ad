"""Every loss of the inverse fit against difference quotients, and in what unit it measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.fabrics import get_fabric, load_fabrics
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.seams import equalise_seams
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.fit.losses.chamfer import ChamferLoss
from garmentq.core.recover.fit.losses.contours import ContourLoss
from garmentq.core.recover.fit.losses.panels import PanelLoss
from garmentq.core.recover.fit.losses.range import RangeLoss, logarithms
from garmentq.core.recover.fit.losses.seams import SeamLoss
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import Contour, Target
from plane_loss import PlaneLoss

Evaluate = Callable[[np.ndarray], tuple[float, np.ndarray]]


def check_gradient(evaluate: Evaluate, at: np.ndarray, step: float, rel: float = 1e-5) -> None:
    """Compare with central differences along random directions; a wrong factor, sign or index breaks it."""
    rng = np.random.default_rng(0)
    _, gradient = evaluate(at)
    assert gradient.shape == at.shape
    assert np.abs(gradient).max() > 0.0
    for _ in range(4):
        way = rng.normal(size=at.shape)
        change = (evaluate(at + step * way)[0] - evaluate(at - step * way)[0]) / (2.0 * step)
        assert float((gradient * way).sum()) == pytest.approx(change, rel=rel, abs=rel * float(np.abs(gradient).sum()))


def tube(count: int, rows: int, radius: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Return an upright tube [m], open above and below, faces outward."""
    angle = 2.0 * np.pi * np.arange(count) / count
    levels = np.linspace(0.0, height, rows)
    ring = np.stack([radius * np.sin(angle), np.zeros(count), radius * np.cos(angle)], axis=1)
    vertices = np.concatenate([ring + [0.0, level, 0.0] for level in levels])
    faces = []
    for r in range(rows - 1):
        for c in range(count):
            a, b = r * count + c, r * count + (c + 1) % count
            faces += [[a, b, b + count], [a, b + count, a + count]]
    return vertices, np.array(faces)


@pytest.fixture(scope="module")
def skirt() -> Garment:
    """The shipped skirt's mesh, wrapped round a tube of 15 cm radius, its contours named by height."""
    garment = mesh_pattern(load_template("skirt"), 250)
    rng = np.random.default_rng(1)
    height, angle = np.zeros(len(garment.nodes)), np.zeros(len(garment.nodes))
    height[garment.uv_node] = garment.uv[:, 1] - garment.uv[:, 1].min()
    behind = np.array(["back" in panel.name for panel in garment.pattern.panels])[garment.panel_of_uv]
    half = np.abs(garment.uv[:, 0]).max()
    angle[garment.uv_node] = 0.5 * np.pi * garment.uv[:, 0] / half + np.pi * behind
    nodes = np.stack([0.15 * np.sin(angle), height, 0.15 * np.cos(angle)], axis=1)
    nodes += rng.normal(0, 3e-3, nodes.shape)
    hem = min(find_loops(garment.faces, nodes), key=lambda loop: nodes[loop, 1].mean())
    return garment.at(nodes, (Contour("hem", hem, 1.0),))


@pytest.fixture(scope="module")
def target(skirt: Garment) -> Target:
    vertices, faces = tube(40, 12, 0.16, float(skirt.nodes[:, 1].max()) * 0.9)
    hem = Contour("hem", np.arange(40), 1.0)
    return Target(vertices, faces, vertex_normals(vertices, faces), (hem,), (), "skirt")


@pytest.mark.parametrize("curvature", [0.0, 1.0])
def test_gradient_of_the_chamfer_distance(skirt: Garment, target: Target, curvature: float) -> None:
    """A closest point that is not differentiated by the envelope theorem, or a weight that is lost, breaks this."""
    loss = ChamferLoss.of(skirt, target.vertices, target.faces, curvature)
    check_gradient(loss.evaluate, skirt.nodes, 1e-8, rel=1e-4)


def test_the_chamfer_distance_is_in_square_metres(target: Target) -> None:
    """Two tubes a centimetre apart: 1e-4 m2 each way; a sum in place of a mean breaks this."""
    vertices, faces = tube(80, 24, 0.17, 1.0)
    like = load_template("skirt")
    panel = replace(mesh_pattern(like, 60), faces=faces, uv_faces=faces, uv=vertices[:, :2], nodes=vertices)
    flat = replace(panel, uv=np.stack([np.tile(np.arange(80.0), 24), np.repeat(np.arange(24.0), 80)], axis=1))
    goal, goal_faces = tube(80, 24, 0.16, 1.0)
    for curvature in (0.0, 1.0):
        value, _ = ChamferLoss.of(flat, goal, goal_faces, curvature).evaluate(vertices)
        assert value == pytest.approx(2e-4, rel=0.03)
    assert PlaneLoss.of(flat, goal, goal_faces).evaluate(vertices)[0] == pytest.approx(1e-4, rel=0.12)


def test_curved_places_count_more() -> None:
    """Breaks where the weight falls with curvature or is not of mean 1."""
    vertices, faces = tube(60, 40, 0.02, 0.4)
    flat = vertices * [1.0, 1.0, 5.0]
    loss = ChamferLoss.of(mesh_pattern(load_template("skirt"), 60), flat, faces)
    sharp = np.abs(flat[:, 0]) < 0.002
    blunt = np.abs(flat[:, 0]) > 0.0199
    inner = (flat[:, 1] > 0.05) & (flat[:, 1] < 0.35)
    assert loss.weights[sharp & inner].min() > 1.5 * loss.weights[blunt & inner].max()
    assert float(loss.goal_shares @ loss.weights) == pytest.approx(1.0)


def test_gradient_of_the_distance_to_planes(skirt: Garment, target: Target) -> None:
    """A normal of the wrong face, or a foot that is differentiated, breaks this."""
    loss = PlaneLoss.of(skirt, target.vertices, target.faces)
    check_gradient(loss.evaluate, skirt.nodes, 1e-8, rel=1e-4)
    on = target.vertices[target.faces].mean(1)[: len(skirt.nodes)]
    nodes = skirt.nodes.copy()
    nodes[: len(on)] = on
    assert loss.evaluate(nodes)[1][: len(on)] == pytest.approx(0.0, abs=1e-12)


def test_gradient_of_the_contours(skirt: Garment, target: Target) -> None:
    """A share given to the wrong end of an edge breaks this; an untrusted contour that counts does, too."""
    loss = ContourLoss.of(skirt, target)
    assert len(loss.contours) == 1
    check_gradient(loss.evaluate, skirt.nodes, 1e-7)
    hem = replace(target.contours[0], trusted=False)
    assert ContourLoss.of(skirt, replace(target, contours=(hem,))).evaluate(skirt.nodes)[0] == 0.0
    lifted = skirt.nodes.copy()
    loop = skirt.contours[0].vertices
    angle = 2.0 * np.pi * np.arange(len(loop)) / len(loop)
    lifted[loop] = np.stack([0.16 * np.sin(angle), np.full(len(loop), 0.01), 0.16 * np.cos(angle)], axis=1)
    assert loss.evaluate(lifted)[0] == pytest.approx(1e-4, rel=0.1)


def test_gradient_of_the_seams(skirt: Garment) -> None:
    """A side that is pulled the wrong way, or a curve's length over chord that is lost, breaks this."""
    loss = SeamLoss.of(skirt, skirt.pattern)
    rng = np.random.default_rng(2)
    equal = equalise_seams(skirt.pattern).points
    assert loss.evaluate(equal)[0] < 1e-12
    moved = equal + rng.normal(0, 0.01, equal.shape)
    check_gradient(lambda points: loss.evaluate(points)[:2], moved, 1e-6)


def gather(pattern: Pattern) -> Pattern:
    first: Seam = replace(pattern.seams[0], gathered=True)
    return replace(pattern, seams=(first, *pattern.seams[1:]))


def test_a_gathered_ratio_is_free(skirt: Garment) -> None:
    """Breaks where a gathered seam's ratio is no parameter, or moves another seam."""
    gathered = replace(skirt, pattern=gather(skirt.pattern))
    loss = SeamLoss.of(gathered, gathered.pattern)
    points = gathered.pattern.points.copy()
    seam = gathered.pattern.seams[0]
    index = [panel.name for panel in gathered.pattern.panels].index(seam.a.panel)
    first = int(gathered.pattern.point_starts[index])
    points[first + seam.a.edge] += [0.0, 0.02]
    at = np.array([0.1])
    check_gradient(lambda logs: loss.evaluate(points, logs)[::2], at, 1e-6)
    values = [loss.evaluate(points, np.array([log]))[0] for log in np.linspace(-0.2, 0.2, 401)]
    assert min(values) < 0.5 * loss.evaluate(points)[0]
    best = loss.best_ratios(points)
    assert loss.evaluate(points, best)[0] <= min(values)
    assert loss.evaluate(points, best)[2] == pytest.approx(0.0, abs=1e-12)


def test_gradient_of_the_range() -> None:
    """Breaks where a bound has the wrong side: nothing inside, squares outside, and H stays positive definite."""
    fabric = get_fabric("cotton_poplin")
    loss = RangeLoss.of(fabric)
    assert loss.evaluate(logarithms(fabric))[0] == 0.0
    assert all(
        loss.evaluate(logarithms(each) - np.log(each.density / fabric.density))[0] < 1e-9 for each in load_fabrics()
    )
    out = np.array([loss.high[0] + 1.0, loss.low[1] - 0.5, loss.high[2], loss.low[3], loss.high[4] + 0.2])
    assert loss.evaluate(out)[0] == pytest.approx(1.0 + 0.25 + 0.04)
    stuck = logarithms(fabric)
    stuck[1] = 0.5 * (stuck[0] + stuck[2])
    for at in (out, stuck):
        check_gradient(loss.evaluate, at, 1e-6)


@pytest.mark.parametrize("name", ["skirt", "tshirt"])
def test_gradient_of_the_panels(name: str) -> None:
    """Breaks where a triangle's slope, a corner's neighbour or the control map is wrong."""
    garment = mesh_pattern(load_template(name), 250)
    loss = PanelLoss.of(garment, garment.pattern)
    points = garment.pattern.points
    assert loss.evaluate(points)[0] == 0.0
    rng = np.random.default_rng(3)
    squeezed = points * [0.2, 1.0] + rng.normal(0, 0.01, points.shape)
    check_gradient(loss.evaluate, squeezed, 1e-7, rel=1e-4)


def test_smooth_curves_are_kept(skirt: Garment) -> None:
    """Breaks where no smooth point is kept, or a similarity of a panel counts as a change."""
    loss = PanelLoss.of(skirt, skirt.pattern)
    turned = skirt.pattern.points @ np.array([[0.8, -0.6], [0.6, 0.8]]) * 1.1
    assert loss.evaluate(turned)[0] == pytest.approx(0.0, abs=1e-12)
    assert len(loss.points)
    bent = skirt.pattern.points.copy()
    bent[loss.points[0]] += [0.01, 0.01]
    assert 1e-7 < loss.evaluate(bent)[0] < 1e-3


def test_right_angles_at_centre_lines_are_kept() -> None:
    """Breaks where a centre line is not found by its mirror image, or another corner is kept: a trapezium in halves."""
    left = np.array([[0.0, 0.0], [0.3, 0.0], [0.2, 0.5], [0.0, 0.5]])
    right = np.array([[0.0, 0.5], [-0.2, 0.5], [-0.3, 0.0], [0.0, 0.0]])
    panels = tuple(Panel(name, points, (Edge(),) * 4) for name, points in (("left", left), ("right", right)))
    pattern = Pattern("halves", panels, (Seam(EdgeRef("left", 3), EdgeRef("right", 3)),))
    loss = PanelLoss.of(mesh_pattern(pattern, 60), pattern)
    assert set(loss.points.tolist()) == {0, 3, 4, 7}
    points = pattern.points
    assert loss.evaluate(points * [1.2, 0.9])[0] == pytest.approx(0.0, abs=1e-15)
    sheared = points + np.outer(points[:, 0], [0.0, 0.1])
    angle = np.arctan(0.1)
    arms = np.array([0.4, 0.35, 0.35, 0.4])
    assert loss.evaluate(sheared)[0] == pytest.approx(float((arms**2).mean()) * angle**2, rel=1e-6)
