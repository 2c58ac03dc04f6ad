"""Dress forms: a trunk alone is a wearer, a garment alone is none."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.dress_form import is_solid, register_dress_form, register_wearer
from garmentq.core.body.registration import NotHuman
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.geometry.connectivity import HalfEdges, find_components
from garmentq.core.geometry.geometry import unit
from garmentq.core.scan.contours.garment import PartMissing, check_carried
from garmentq.core.scan.units import UnitsUnknown, find_units

LIMBS = ("shoulder", "elbow", "wrist", "hand"), ("hip", "knee", "ankle", "foot")


def trunk_faces(body: Body, arm: float, leg: float) -> np.ndarray:
    """Return the faces of trunk and neck, of the upper arms up to a share, and of the thighs up to a share."""
    gone = np.zeros(len(body.vertices), dtype=bool)
    for names, share in zip(LIMBS, (arm, leg), strict=True):
        for side in ("left", "right"):
            own = body.weights[:, [JOINTS.index(f"{side}_{name}") for name in names]].sum(axis=1) > 0.5
            first, last = (body.joint(f"{side}_{name}") for name in names[:2])
            along = (body.vertices - first) @ (last - first) / ((last - first) @ (last - first))
            gone |= own & (along > share)
    middle = 0.5 * (body.joint("neck") + body.joint("head"))[1]
    gone |= (body.weights[:, [JOINTS.index("neck"), JOINTS.index("head")]].sum(axis=1) > 0.5) & (
        body.vertices[:, 1] > middle
    )
    faces = body.faces[~gone[body.faces].any(axis=1)]
    _, piece = HalfEdges.of(faces, len(body.vertices)).vertex_pieces
    return faces[piece[faces[:, 0]] == np.bincount(piece[faces[:, 0]]).argmax()]


def close(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a mesh with a fan over each border."""
    edges = HalfEdges.of(faces, len(vertices))
    tail, head = edges.tail[edges.border], edges.head[edges.border]
    _, piece = find_components(len(vertices), tail, head)
    fans = []
    for one in np.unique(piece[tail]):
        rim = piece[tail] == one
        fans.append(np.column_stack([head[rim], tail[rim], np.full(rim.sum(), len(vertices))]))
        vertices = np.vstack([vertices, vertices[tail[rim]].mean(axis=0)])
    return vertices, np.concatenate([faces, *fans])


def make_form(spec: str, arm: float = 0.25, leg: float = 0.35) -> tuple[Body, np.ndarray, np.ndarray]:
    """Return a body, and the closed form of its trunk."""
    body = builtin_body(BuiltinWearer(spec))
    vertices, faces = close(body.vertices, trunk_faces(body, arm, leg))
    used, faces = np.unique(faces, return_inverse=True)
    return body, vertices[used], faces.reshape(-1, 3)


@pytest.mark.parametrize(
    ("spec", "arm", "leg", "heading"),
    [("builtin:female,height=1.72", 0.25, 0.35, 1.1), ("builtin:male,height=1.80", 0.1, 0.1, -2.0)],
)
def test_the_trunk_of_a_form_is_found(spec, arm, leg, heading):
    """Broken where the front is taken for the back, the lids draw the trunk, or a stump is a short arm."""
    body, vertices, faces = make_form(spec, arm, leg)
    turn = np.array(
        [[np.cos(heading), 0.0, np.sin(heading)], [0.0, 1.0, 0.0], [-np.sin(heading), 0.0, np.cos(heading)]]
    )
    place = np.array([0.3, 0.7, -0.2])
    found = register_wearer(vertices @ turn.T + place, faces, name="stand")
    assert found.source == "form:stand" and found.is_dress_form and len(found.vertices) == len(vertices)
    for name in ("pelvis", "spine3", "neck", "left_hip", "right_hip", "left_shoulder"):
        assert np.linalg.norm(found.joint(name) - (turn @ body.joint(name) + place)) < 0.015, name
    shin = unit(found.joint("left_ankle") - found.joint("left_hip"))
    assert shin[1] < -0.95  # the legs that it lacks hang straight below it


def test_a_garment_is_no_form():
    """Broken where a shirt's own surface, given as its body, is taken for a trunk; or a box is."""
    body, vertices, faces = make_form("builtin:female,height=1.72")
    assert is_solid(vertices, faces)
    shirt = trunk_faces(body, 0.25, 0.05)
    assert not is_solid(body.vertices, shirt)
    with pytest.raises(NotHuman, match="no faces"):
        register_wearer(vertices, np.zeros((0, 3), dtype=np.int64))
    box = np.array([[x, y, z] for x in (-0.2, 0.2) for y in (0.0, 0.7) for z in (-0.1, 0.1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])
    assert is_solid(box, triangles) and register_dress_form(box, triangles) is None


def test_a_form_has_its_own_sizes():
    """Broken where a form of 70 cm is a doll, or a person's unit changes."""
    _, vertices, _ = make_form("builtin:female,height=1.72")
    assert find_units(vertices, "body") == "m" and find_units(1000.0 * vertices, "body") == "mm"
    with pytest.raises(UnitsUnknown, match="inch"):
        find_units(100.0 * vertices, "body")  # or a person of 76 inches
    body = builtin_body(BuiltinWearer("builtin:female,height=1.72"))
    assert find_units(1000.0 * body.vertices, "body") == "mm"
    with pytest.raises(UnitsUnknown):
        find_units(0.4 * vertices, "body")


def test_sleeves_need_arms():
    """Broken where a shirt with sleeves becomes a tank top with two holes, or a small gap is a sleeve."""
    check_carried([0.05], "tank")
    with pytest.raises(PartMissing, match="33 cm"):
        check_carried([0.05, 0.33], "shirt")
