"""Grading on tubes, whose flat pattern is known for every target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.garment.curves import panel_area
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import list_templates
from garmentq.core.garment.validity import check_outline
from garmentq.core.recover.grade.choice import TemplateMissing, rank_templates
from garmentq.core.recover.grade.grading import grade_pattern
from garmentq.core.recover.grade.registration import register_coarsely
from garmentq.core.run.errors import Cancelled
from garmentq.core.run.hooks import Hooks
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import Contour, Target

WIDTH, HEIGHT, TOP = 0.4, 0.5, 1.0


def draw(width: float, height: float) -> Pattern:
    """Draw a tube of two rectangles, hem at the bottom."""
    points = np.array([[-width / 2, -height], [width / 2, -height], [width / 2, 0.0], [-width / 2, 0.0]])
    edges = (Edge(contour="hem"), Edge(), Edge(contour="waist"), Edge())
    front = Panel("front", points, edges, np.eye(3), np.array([0, TOP, 0.25]))
    back = Panel("back", points, edges, np.diag([-1.0, 1, -1]), np.array([0, TOP, -0.25]))
    seams = tuple(Seam(EdgeRef("front", a), EdgeRef("back", b)) for a, b in ((1, 3), (3, 1)))
    return Pattern("tube", (front, back), seams, "skirt")


def roll(width: float, height: float, count: int, top: float = TOP):
    """Mesh a tube and roll it around the y axis without strain."""
    garment = mesh_pattern(draw(width, height), count)
    radius = width / np.pi
    angle = garment.uv[:, 0] / radius
    side = np.where(garment.panel_of_uv == 0, 1.0, -1.0)
    nodes = np.zeros((len(garment.nodes), 3))
    placed = np.stack([side * radius * np.sin(angle), top + garment.uv[:, 1], side * radius * np.cos(angle)], axis=1)
    nodes[garment.uv_node] = placed
    return garment.at(nodes, name_rims(nodes, garment.faces))


def name_rims(nodes: np.ndarray, faces: np.ndarray) -> tuple[Contour, ...]:
    """Name both rims of a tube."""
    contours = []
    for loop in find_loops(faces):
        points = nodes[loop]
        length = float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum())
        contours.append(Contour("hem" if points[:, 1].mean() < nodes[:, 1].mean() else "waist", loop, length))
    return tuple(contours)


def aim(garment, nodes: np.ndarray | None = None) -> Target:
    """Make a target of a rolled tube."""
    nodes = garment.nodes if nodes is None else nodes
    return Target(nodes, garment.faces, np.zeros_like(nodes), garment.contours, (), "skirt")


@pytest.fixture(scope="module")
def body() -> Body:
    """Stand a straight skeleton along the tube."""
    heights = {
        "pelvis": 0.9, "spine1": 1.0, "spine2": 1.1, "spine3": 1.2, "neck": 1.4, "head": 1.5,
        "hip": 0.85, "knee": 0.5, "ankle": 0.1, "foot": 0.02,
    }  # fmt: skip
    joints = np.array([[0.0, heights.get(name.rpartition("_")[2], 1.3), 0.0] for name in JOINTS])
    none, index = np.zeros((0, 3)), np.zeros((0, 3), dtype=int)
    weights, transforms = np.zeros((0, 24)), np.zeros((24, 4, 4))
    return Body(none, index, joints, weights, transforms, none, index, joints, weights, np.eye(3))


@pytest.fixture(scope="module")
def source():
    """Roll the base tube."""
    return roll(WIDTH, HEIGHT, 500)


def size_of(pattern: Pattern) -> np.ndarray:
    """Return width and height of the front panel."""
    return np.ptp(pattern.panel("front").points, axis=0)


@pytest.mark.parametrize(
    ("width", "height", "top"), [(0.5, 0.5, 1.0), (0.4, 0.8, 1.0), (0.6, 0.8, 1.0), (0.3, 0.3, 1.05), (0.8, 0.5, 1.0)]
)
def test_another_tube_gives_its_own_pattern(source, body, width, height, top):
    """Breaks where girth or length is measured wrongly, or smoothing eats a part of it."""
    grading = grade_pattern(source, aim(roll(width, height, 800, top)), body)
    assert size_of(grading.pattern) == pytest.approx([width, height], abs=0.004)
    assert seam_mismatch(grading.pattern) < 1e-4
    assert grading.share == 1.0
    hem = next(m for m in grading.contours if m.name == "hem")
    assert hem.distance == pytest.approx((height - top) - (HEIGHT - TOP), abs=0.002)
    assert hem.target_length == pytest.approx(2 * width, rel=0.01)


def test_the_same_tube_changes_nothing(source, body):
    """Breaks where grading is no contraction: another mesh of the same garment must not move the pattern."""
    grading = grade_pattern(source, aim(roll(WIDTH, HEIGHT, 900)), body)
    assert np.abs(grading.pattern.points - source.pattern.points).max() < 0.002
    again = grade_pattern(grading.garment, aim(roll(WIDTH, HEIGHT, 900)), body)
    assert np.abs(again.pattern.points - source.pattern.points).max() < 0.002


def test_the_graded_mesh_lies_on_the_target_with_its_new_pattern(source, body):
    """Breaks where nodes, flat vertices and pattern of the graded garment disagree."""
    garment = grade_pattern(source, aim(roll(0.5, 0.7, 800)), body).garment
    assert np.abs(np.hypot(garment.nodes[:, 0], garment.nodes[:, 2]) - 0.5 / np.pi).max() < 0.004
    assert np.ptp(garment.uv[garment.panel_of_uv == 0], axis=0) == pytest.approx(size_of(garment.pattern), abs=1e-9)
    assert garment.faces is source.faces


def test_a_pulled_template_does_not_shrink_the_pattern(body):
    """Breaks where the strain of a template that was stretched over the body is taken for the target's own."""
    source = roll(WIDTH, HEIGHT, 500)
    tight = source.at(source.nodes * [1.3, 1.0, 1.3])
    grading = grade_pattern(tight, aim(roll(0.52, HEIGHT, 800)), body)
    assert size_of(grading.pattern)[0] == pytest.approx(0.52 / 1.03, abs=0.004)


def test_rigid_motion_changes_nothing(source, body):
    """Breaks where a step depends on the world's axes."""
    turn = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
    move = np.array([0.3, -0.2, 0.5])
    goal = roll(0.5, 0.6, 600)
    plain = grade_pattern(source, aim(goal), body).pattern.points
    there = replace(body, joints=body.joints @ turn.T + move)
    moved = grade_pattern(source.at(source.nodes @ turn.T + move), aim(goal, goal.nodes @ turn.T + move), there)
    assert np.abs(moved.pattern.points - plain).max() < 1e-4


def test_a_mirrored_target_gives_the_mirrored_pattern(source, body):
    """Breaks where left and right are treated unlike; the tube's pattern is symmetric, so both must agree."""
    goal = roll(0.5, 0.6, 600)
    bent = goal.nodes + np.array([0.1, 0.0, 0.0]) * ((goal.nodes[:, 1:2] - TOP) / 0.6) ** 2
    plain = grade_pattern(source, aim(goal, bent), body).pattern
    flipped = replace(goal, faces=goal.faces[:, ::-1])
    nodes = bent * [-1.0, 1.0, 1.0]
    flipped = flipped.at(nodes, name_rims(nodes, flipped.faces))
    mirrored = grade_pattern(source, aim(flipped), body).pattern
    assert np.abs(plain.points - mirrored.points).max() < 0.003


@pytest.mark.parametrize(("width", "height", "top"), [(0.06, 0.04, 1.3), (1.6, 0.03, 0.2), (0.05, 1.5, 1.2)])
def test_extreme_targets_fold_no_panel(source, body, width, height, top):
    """Breaks where the guard against fold-over is lost: outlines stay simple and counter-clockwise, seams equal."""
    grading = grade_pattern(source, aim(roll(width, height, 500, top)), body)
    for panel in grading.pattern.panels:
        check_outline(panel)
        assert panel_area(panel) > 0
    assert seam_mismatch(grading.pattern) < 1e-4
    assert np.isfinite(grading.garment.nodes).all()


def test_untrusted_and_missing_contours_do_not_pull(source, body):
    """Breaks where a cut-off hem shortens the pattern: an untrusted contour is no design."""
    goal = roll(WIDTH, HEIGHT, 800)
    cut = tuple(replace(c, trusted=c.name != "hem") for c in goal.contours)
    moved = register_coarsely(source, replace(aim(goal), contours=cut))
    assert np.abs(moved - source.nodes).max() < 0.01
    grading = grade_pattern(source, replace(aim(goal), contours=goal.contours[:1]), body)
    assert len(grading.warnings) == 1 and "no contour" in grading.warnings[0]


@pytest.mark.parametrize("seed", [0, 1])
def test_cloth_beyond_a_crumpled_end_keeps_its_length(source, seed):
    """Fails where the end of a sleeve whose cuff is too crumpled to be trusted is thrown out to a point."""
    short = 0.7 * HEIGHT
    goal = roll(0.8 * WIDTH, short, 800)
    depth = np.clip((TOP - goal.nodes[:, 1] - 0.5 * short) / short, 0.0, 0.5)
    crumple = np.random.default_rng(seed).normal(size=goal.nodes.shape) * 0.02 * depth[:, None]
    torn = aim(goal, goal.nodes + crumple)
    contours = tuple(replace(line, trusted=line.name != "hem") for line in torn.contours)
    moved = register_coarsely(source, replace(torn, contours=contours))
    ends = source.nodes[:, 1] < TOP - short
    faces = source.faces[ends[source.faces].all(axis=1)]

    def lengths(nodes: np.ndarray) -> np.ndarray:
        return np.linalg.norm(nodes[faces] - np.roll(nodes[faces], 1, axis=1), axis=2)

    grown = lengths(moved) / lengths(source.nodes)
    assert 0.7 < np.median(grown) < 1.1
    assert np.quantile(grown, 0.95) < 1.7


def test_cancelling_stops_the_registration(source, body):
    """Breaks where a running grading cannot be stopped."""
    with pytest.raises(Cancelled):
        grade_pattern(source, aim(source), body, hooks=Hooks(is_cancelled=lambda: True))


def opened(source, category, lengths):
    """Return a target with contours of some lengths [m], and nothing else that the choice may look at."""
    contour = source.contours[0]
    contours = tuple(replace(contour, name=name, length=length, trusted=True) for name, length in lengths.items())
    return replace(aim(source), category=category, contours=contours)


ARMS = {"neck": 0.6, "cuff.left": 0.3, "cuff.right": 0.3}
BARE = {"neck": 0.6, "armhole.left": 0.45, "armhole.right": 0.45}
LEGS = {"leg.left": 0.5, "leg.right": 0.5}


@pytest.mark.parametrize(
    ("category", "lengths", "name"),
    [
        ("tshirt", ARMS | {"hem": 1.0}, "tshirt"),
        ("long_sleeve_tshirt", ARMS | {"hem": 1.0}, "long_sleeve_tshirt"),
        ("tank", BARE | {"hem": 0.9}, "tank"),
        ("dress", BARE | {"hem": 1.4}, "dress"),
        ("dress", ARMS | {"hem": 1.4}, "sleeved_dress"),
        ("dress", {"neck": 0.6, "cuff.left": 0.3, "hem": 1.4}, "sleeved_dress"),
        ("trousers", {"waist": 0.8} | LEGS, "trousers"),
        ("shorts", {"waist": 0.8} | LEGS, "shorts"),
        ("jumpsuit", BARE | LEGS, "jumpsuit"),
        ("jumpsuit", ARMS | LEGS, "sleeved_jumpsuit"),
        ("skirt", {"waist": 0.75, "hem": 1.3}, "skirt"),
        ("skirt", {"waist": 0.9, "hem": 1.56}, "skirt"),
        ("skirt", {"waist": 0.75, "hem": 3.0}, "four_panel_skirt"),
        ("skirt", {"waist": 0.7, "hem": 0.95}, "pencil_skirt"),
        ("skirt", {"hem": 0.95}, "skirt"),
    ],
)
def test_each_garment_has_its_template(source, category, lengths, name):
    """Breaks where a garment is graded from a template of another topology or of a shape further off."""
    names = tuple(info.name for info in list_templates())
    assert rank_templates(opened(source, category, lengths), names)[0][0] == name


@pytest.mark.parametrize(("category", "name"), [("shorts", "trousers"), ("long_sleeve_tshirt", "tshirt")])
def test_sleeves_and_legs_of_any_length_are_graded_from_one(source, category, name):
    """Breaks where a caller's shorter list of templates leaves a garment without one that can be graded to it."""
    target = replace(aim(source), category=category)
    assert rank_templates(target, ("tshirt", "tank", "dress", "trousers", "skirt"))[0][0] == name


def test_a_category_without_template_is_refused(source):
    """Breaks where an unknown garment is silently graded from something else."""
    with pytest.raises(TemplateMissing, match="jumpsuit"):
        rank_templates(replace(aim(source), category="jumpsuit"), ("tshirt",))
