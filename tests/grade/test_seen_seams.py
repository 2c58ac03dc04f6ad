"""What curvature shows of seams: the hollow points of shoulders, and which nodes are held where."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.pattern import EdgeRef
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_draped_template, load_template
from garmentq.core.recover.grade import seen_seams
from garmentq.core.recover.grade.seen_seams import find_seen_seams
from garmentq.core.recover.grade.shoulder_points import find_shoulder_points
from garmentq.core.recover.grade.trunk_curvature import TrunkCurvature
from garmentq.core.recover.grade.waist_seam import WaistLine
from garmentq.core.scan.contours.target import Target

BODY = builtin_body("builtin:female,height=1.70")


def roof(points: list[tuple[float, float]], rise: float, *, noise: float = 0.0, neck: float = 0.0) -> TrunkCurvature:
    """Return a sheet over both shoulders with a hollow point, z = rise r cos 2 theta, at places on the left [m].

    Places are outwards of the shoulder joint and before it; the right side is the mirror image. Up to `neck` from the
    middle, inwards of the joints, the sheet is open.
    """
    rng = np.random.default_rng(0)
    left = BODY.joint("left_shoulder")
    across, along = np.arange(-0.4, 0.401, 0.01), np.arange(-0.15, 0.151, 0.01)
    x, z = np.meshgrid(across, along)
    up = np.zeros_like(x)
    for outwards, before in points:
        a, b = np.abs(x) - left[0] - outwards, z - left[2] - before
        up += rise * np.hypot(a, b) * np.cos(2.0 * np.arctan2(b, a))
    vertices = np.stack([x, left[1] + 0.02 + up, z], axis=2).reshape(-1, 3)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    faces = np.concatenate([np.stack([a, c, b], 2).reshape(-1, 3), np.stack([a, d, c], 2).reshape(-1, 3)])
    vertices = vertices + noise * rng.normal(size=vertices.shape)
    faces = faces[(np.abs(vertices[faces, 0]) >= neck).all(axis=1)]
    return TrunkCurvature.of(Target(vertices, faces, np.zeros_like(vertices), (), (), "tshirt"), BODY)


@pytest.mark.parametrize("noise", [0.0, 0.0003])
def test_a_hollow_point_on_each_shoulder_is_found(noise: float) -> None:
    """Broken where a point is off by more than an edge, or left and right are exchanged."""
    cloth = roof([(0.03, 0.01)], 0.45, noise=noise)
    found = find_shoulder_points(cloth)
    assert found is not None
    for place, joint, outwards in zip(found, cloth.shoulders, (0.03, -0.03), strict=True):
        assert abs(place[0] - joint[0] - outwards) < 0.015
        assert abs(place[2] - joint[2] - 0.01) < 0.015


@pytest.mark.parametrize(
    ("points", "rise", "noise"),
    [([(0.03, 0.0)], 0.1, 0.0), ([(-0.06, 0.0), (0.06, 0.0)], 0.45, 0.0), ([], 0.0, 0.001)],
)
def test_cloth_that_shows_no_such_point(points: list[tuple[float, float]], rise: float, noise: float) -> None:
    """Broken where a slight hollow, one of two, or noise is taken for the end of an armhole."""
    assert find_shoulder_points(roof(points, rise, noise=noise)) is None


def test_a_hollow_beside_the_neck_is_no_end_of_an_armhole() -> None:
    """Broken where the rim of a neck, around which half of the cloth is missing, draws the armholes to itself."""
    joint = float(BODY.joint("left_shoulder")[0])
    for inwards, is_found in ((0.02, False), (0.06, True)):
        cloth = roof([(0.03, 0.01)], 0.45, neck=joint + 0.03 - inwards)
        assert (find_shoulder_points(cloth) is not None) == is_found


@pytest.fixture(scope="module")
def body() -> Body:
    """Return the body that the library's garments hang on."""
    return builtin_body("builtin:female")


def test_the_tops_of_armholes_are_held_across_the_shoulders(body: Body, monkeypatch: pytest.MonkeyPatch) -> None:
    """Broken where the underarm's node is held in place of the shoulder's, or one side at the other's place."""
    worn = load_draped_template("tshirt")
    assert worn is not None
    target = Target(worn.nodes, worn.faces, np.zeros_like(worn.nodes), worn.contours, (), "tshirt")
    wanted = np.array([[0.21, 1.4, 0.0], [-0.20, 1.4, 0.0]])
    monkeypatch.setattr(seen_seams, "find_shoulder_points", lambda cloth: tuple(wanted))
    seen = find_seen_seams(worn, target, body)
    assert [seam.nodes.shape for seam in seen] == [(1,), (1,)]
    sleeves = {
        node
        for seam in worn.pattern.seams
        for ref in (seam.a, seam.b)
        if ref.panel.startswith("sleeve")
        for node in worn.uv_node[worn.edge_uv[ref]]
    }
    for seam, place in zip(seen, wanted, strict=True):
        node = worn.nodes[seam.nodes[0]]
        assert int(seam.nodes[0]) in sleeves and node[1] > body.joint("left_shoulder")[1] - 0.02
        assert seam.distance(worn.nodes)[0] == pytest.approx(node[0] - (place[0] + body.joint("pelvis")[0]), abs=1e-6)
        assert np.sign(node[0] - body.joint("pelvis")[0]) == np.sign(place[0])


def test_a_waist_seam_is_held_where_its_line_is_seen(body: Body, monkeypatch: pytest.MonkeyPatch) -> None:
    """Broken where nodes of other seams, or at the sides, are held at the waist's height."""
    pattern = load_template("dress+skirt=half-circle,waist=seam")
    mesh = mesh_pattern(pattern, 600)
    places = np.stack([mesh.uv[:, 0], mesh.uv[:, 1], np.zeros(len(mesh.uv))], axis=1)
    nodes = np.zeros((len(mesh.nodes), 3))
    nodes[mesh.uv_node] = places
    garment = mesh.at(nodes)
    target = Target(nodes, mesh.faces, np.zeros_like(nodes), (), (), "dress")
    line = WaistLine(np.array([0.0, 1.0, 0.0]), 1.0, np.array([1.0, 0.0, 0.0]), 0.0, 0.1)
    monkeypatch.setattr(seen_seams, "find_waist_line", lambda cloth: line)
    (seen,) = find_seen_seams(garment, target, body)
    waist = {
        int(node)
        for panel in pattern.panels
        for i, edge in enumerate(panel.edges)
        if edge.label.startswith("waist.")
        for node in mesh.uv_node[mesh.edge_uv[EdgeRef(panel.name, i)]]
    }
    assert set(seen.nodes.tolist()) == {node for node in waist if abs(nodes[node, 0]) < 0.1}
    assert np.allclose(seen.distance(nodes), nodes[seen.nodes, 1] - 1.0)


def test_a_garment_without_such_seams_is_not_looked_at(body: Body, monkeypatch: pytest.MonkeyPatch) -> None:
    """Broken where the curvature of a skirt is computed for nothing."""
    worn = load_draped_template("skirt")
    assert worn is not None
    target = Target(worn.nodes, worn.faces, np.zeros_like(worn.nodes), worn.contours, (), "skirt")
    monkeypatch.setattr(TrunkCurvature, "of", None)
    assert find_seen_seams(worn, target, body) == ()
