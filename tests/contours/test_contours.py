"""Names of contours by encirclement, holes, and the category that follows."""

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.contours.category import choose_category
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.contours.encirclement import find_crossings
from garmentq.core.scan.contours.garment import NoContour, segment_garment
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.scan import Scan

NAMES = {
    "tshirt": {"neck", "hem", "cuff.left", "cuff.right"},
    "long_sleeve_tshirt": {"neck", "hem", "cuff.left", "cuff.right"},
    "tank": {"neck", "hem", "armhole.left", "armhole.right"},
    "shorts": {"waist", "leg.left", "leg.right"},
    "trousers": {"waist", "leg.left", "leg.right"},
    "jumpsuit": {"neck", "cuff.left", "cuff.right", "leg.left", "leg.right"},
}


def names_of(contours):
    """Return the set of names."""
    return {contour.name for contour in contours}


@pytest.mark.parametrize("pose", ["T", "A", "arms-down"])
@pytest.mark.parametrize("kind", NAMES)
def test_every_cut_in_every_pose(wearers, skin, kind, pose):
    """Projection on a bone mixes up armhole and cuff, hem and leg: encirclement must not, whatever the arms do."""
    body = wearers[pose]
    vertices, faces = skin(body, kind)
    contours, holes = name_contours(vertices, faces, body)
    assert names_of(contours) == NAMES[kind] and holes == ()
    assert choose_category(contours, vertices, body) == kind


@pytest.mark.parametrize("pose", ["T", "arms-down"])
@pytest.mark.parametrize(
    "top,bottom,names,category",
    [
        (0.61, 0.35, {"waist", "hem"}, "skirt"),
        (0.54, 0.45, {"waist", "hem"}, "skirt"),
        (0.66, 0.02, {"waist", "hem"}, "skirt"),
        (0.74, 0.35, {"neck", "hem"}, "dress"),
        (0.74, 0.55, {"neck", "hem"}, "tank"),
    ],
    ids=["skirt", "low mini", "high maxi", "strapless dress", "strapless top"],
)
def test_tubes(wearers, hung, pose, top, bottom, names, category):
    """A skirt and a strapless dress differ only by where on the trunk they end."""
    body = wearers[pose]
    vertices, faces = hung(body, top, bottom, wave=0.02)
    contours, holes = name_contours(vertices, faces, body)
    assert names_of(contours) == names and holes == ()
    assert choose_category(contours, vertices, body) == category


@pytest.mark.parametrize(("share", "category"), [(0.24, "tank"), (0.38, "tshirt")])
@pytest.mark.parametrize("pose", ["T", "arms-down"])
def test_a_short_sleeve_is_no_armhole(wearers, skin, pose, share, category):
    """Broken where the 9 cm sleeve of a T-shirt passes for a dropped shoulder, or a dropped shoulder for a sleeve."""
    body = wearers[pose]
    vertices, faces = skin(body, "tshirt")
    for side in ("left", "right"):
        shoulder, bone = body.joint(f"{side}_shoulder"), body.joint(f"{side}_elbow") - body.joint(f"{side}_shoulder")
        place = (vertices - shoulder) @ bone / (bone @ bone)
        near = np.linalg.norm(vertices - shoulder - place[:, None] * bone, axis=1) < 0.12
        faces = faces[~(near & (place > share))[faces].any(axis=1)]
    contours, _ = name_contours(vertices, faces, body)
    assert choose_category(contours, vertices, body) == category


def test_a_cuff_that_is_all_but_unseen_keeps_its_place(wearers, skin):
    """Broken where a rim that is drawn in passes for a bay: nothing is left then, and a long sleeve is no long one."""
    body = wearers["T"]
    vertices, faces = skin(body, "long_sleeve_tshirt")
    cuff = {contour.name: contour.vertices for contour in name_contours(vertices, faces, body)[0]}["cuff.left"]
    elbow, wrist = body.joint("left_elbow"), body.joint("left_wrist")
    bone = (wrist - elbow) / np.linalg.norm(wrist - elbow)
    across = vertices[cuff] - wrist - ((vertices[cuff] - wrist) @ bone)[:, None] * bone
    drawn = vertices.copy()
    drawn[cuff] -= 0.3 * across + 0.015 * bone
    unseen = np.ones(len(vertices), bool)
    unseen[cuff[:3]] = False
    contours, _ = name_contours(drawn, faces, body, unseen)
    found = {contour.name: contour for contour in contours}
    assert found["cuff.left"].length > 0.12
    assert choose_category(contours, drawn, body) == "long_sleeve_tshirt"


def test_left_is_the_wearers_left(wearers, skin):
    """A side that follows the world's axes instead of the wearer would be wrong after any turn."""
    body = wearers["T"]
    vertices, faces = skin(body, "tshirt")
    contours, _ = name_contours(vertices, faces, body)
    left = next(contour for contour in contours if contour.name == "cuff.left")
    assert vertices[left.vertices, 0].mean() > 0.2
    assert left.bones == ("left_elbow",)


@pytest.mark.parametrize("yaw", [0.2, 1.6, 3.1])
def test_turning_the_scene_changes_nothing(wearers, skin, yaw):
    """Names, order and lengths must follow the wearer through any heading and place."""
    body = wearers["A"]
    vertices, faces = skin(body, "tshirt")
    before, _ = name_contours(vertices, faces, body)
    turn = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
    moved = replace(body, joints=body.joints @ turn.T + [3.0, -1.0, 2.0])
    after, _ = name_contours(vertices @ turn.T + [3.0, -1.0, 2.0], faces, moved)
    assert [c.name for c in after] == [c.name for c in before]
    for one, two in zip(before, after, strict=True):
        assert np.array_equal(one.vertices, two.vertices) and np.isclose(one.length, two.length, rtol=1e-9)


def test_holes_are_no_contours(wearers, skin):
    """A tear, even one as long as a cuff, encircles no bone and must be listed as a hole."""
    body = wearers["T"]
    vertices, faces = skin(body, "tshirt")
    centres = vertices[faces].mean(axis=1)
    belly = centres[np.argmax(centres[:, 2])]
    back = centres[np.argmin(centres[:, 2] + 0.3 * np.abs(centres[:, 1] - belly[1] - 0.1))]
    keep = (np.linalg.norm(centres - belly, axis=1) > 0.07) & (np.linalg.norm(centres - back, axis=1) > 0.03)
    whole, _ = name_contours(vertices, faces, body)
    contours, holes = name_contours(vertices, faces[keep], body)
    assert len(holes) == 2
    assert [c.name for c in contours] == [c.name for c in whole]
    assert all(np.isclose(a.length, b.length) for a, b in zip(contours, whole, strict=True))


def test_contour_runs_with_the_garment_on_its_left(wearers, hung):
    """The order of a contour carries the side of the garment: seen from above a waist runs clockwise."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.61, 0.35)
    contours, _ = name_contours(vertices, faces, body)
    for contour in contours:
        points = vertices[contour.vertices]
        area = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)[1]
        assert (area < 0) == (contour.name == "waist")


def test_reversed_loop_turns_the_side(wearers, hung):
    """The side on which the garment lies must come from the loop's direction alone."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.61, 0.35)
    for loop in find_loops(faces):
        forward = find_crossings(vertices[loop], body)
        backward = find_crossings(vertices[loop[::-1]], body)
        assert forward and [c.bone for c in forward] == [c.bone for c in backward]
        assert all(a.distal != b.distal for a, b in zip(forward, backward, strict=True))


def test_lifted_knee_keeps_the_hem(wearers, hung):
    """In a stride the hem meets one thigh and one shin, and must still be one hem."""
    body = wearers["T"]
    joints = body.joints.copy()
    joints[4] = joints[1] + [0.0, -0.3, 0.25]
    joints[7] = joints[4] + [0.0, -0.38, -0.1]
    joints[10] = joints[7] + [0.0, -0.04, 0.12]
    striding = replace(body, joints=joints)
    vertices, faces = hung(body, 0.61, 0.27)
    contours, _ = name_contours(vertices, faces, striding)
    assert names_of(contours) == {"waist", "hem"}
    hem = next(contour for contour in contours if contour.name == "hem")
    assert {bone.split("_")[0] for bone in hem.bones} == {"left", "right"}


def test_place_of_a_crossing(wearers):
    """A ring around the middle of a bone must be found on that bone, at its middle."""
    body = wearers["T"]
    elbow, wrist = body.joint("left_elbow"), body.joint("left_wrist")
    way = (wrist - elbow) / np.linalg.norm(wrist - elbow)
    side = np.cross(way, [0.0, 0.0, 1.0])
    angle = 2 * np.pi * np.arange(40) / 40
    ring = 0.25 * elbow + 0.75 * wrist + 0.08 * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * [0, 0, 1.0])
    (crossing,) = find_crossings(ring, body)
    assert crossing.bone == "left_wrist" and np.isclose(crossing.place, 0.75, atol=0.01)
    assert find_crossings(ring + 0.5 * side, body) == ()


def test_target_of_a_scan(wearers, skin):
    """The target must hold outward unit normals and what the contours say."""
    body = wearers["T"]
    vertices, faces = skin(body, "tank")
    target = segment_garment(Scan(vertices, faces), body)
    assert target.category == "tank" and target.contour("neck") is not None and target.contour("waist") is None
    assert np.allclose(np.linalg.norm(target.normals, axis=1), 1.0)
    middle = vertices.mean(axis=0)
    assert (np.einsum("ij,ij->i", target.normals, vertices - middle) > 0).mean() > 0.9


def test_no_open_contour_is_refused(wearers):
    """A closed shell, or a rag that goes around nothing, must end in one clear line."""
    body = wearers["T"]
    with pytest.raises(BadInput) as caught:
        segment_garment(Scan(body.vertices, body.faces, name="closed"), body)
    assert isinstance(caught.value, NoContour) and caught.value.code == "segment.no_contour"
    centres = body.vertices[body.faces].mean(axis=1)
    rag = (centres[:, 2] > 0.08) & (np.abs(centres[:, 1] - 1.05) < 0.15)
    with pytest.raises(NoContour):
        segment_garment(Scan(body.vertices, body.faces[rag]), body)
