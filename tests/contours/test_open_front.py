"""The border of a garment that is open in front is divided into neckline, front edges and hem."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import trimesh
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.curves import Curve
from garmentq.core.scan.contours.category import choose_category
from garmentq.core.scan.contours.contours import name_contours

FRONT = {"front.left", "front.right", "hem", "neck"}


@cache
def wearer(pose: str) -> Body:
    """Return a built-in body in a pose."""
    return builtin_body(f"builtin:female,height=1.70,pose={pose}")


@pytest.mark.parametrize("pose", ["T", "A", "arms-down", "stride", "seated"])
@pytest.mark.parametrize("kind", ["tshirt", "long_sleeve_tshirt", "tank"])
@pytest.mark.parametrize("width", [0.06, 0.16])
def test_an_open_front_is_named(opened, kind: str, pose: str, width: float) -> None:
    """Breaks where the border of an open front is one nameless hole, or its sides are exchanged."""
    body = wearer(pose)
    vertices, faces = opened(body, kind, width)
    contours, holes = name_contours(vertices, faces, body)
    named = {contour.name: contour for contour in contours}
    assert set(named) >= FRONT
    assert len(named) == len(FRONT) + 2  # arms
    assert not any(len(hole) > 20 for hole in holes)
    assert {name for name, contour in named.items() if not contour.is_closed} == FRONT
    lateral = body.joint("left_shoulder") - body.joint("right_shoulder")
    left, right = (vertices[named[f"front.{side}"].vertices].mean(axis=0) for side in ("left", "right"))
    assert (left - right) @ lateral > 0.0
    assert choose_category(contours, vertices, body) == kind


def test_its_parts_follow_each_other(opened) -> None:
    """Breaks where a part of the border is lost between two, or belongs to both."""
    body = wearer("A")
    vertices, faces = opened(body, "tshirt", 0.1)
    contours, _ = name_contours(vertices, faces, body)
    named = {contour.name: contour.vertices for contour in contours}
    order = ("neck", "front.left", "hem", "front.right")
    for name, following in zip(order, (*order[1:], order[0]), strict=True):
        assert named[name][-1] == named[following][0]
    inner = np.concatenate([named[name][1:] for name in order])
    assert len(np.unique(inner)) == len(inner)


def test_lengths_are_those_of_the_edges_alone(opened) -> None:
    """Breaks where the opening is counted as a part of neckline or hem, so that it depends on how it hangs."""
    body = wearer("A")
    vertices, faces = opened(body, "tshirt", 0.16)
    for contour in name_contours(vertices, faces, body)[0]:
        along = contour.curve(vertices).length
        assert 0.85 * along < contour.length <= along  # less the teeth of the cut
    hem = next(one for one in name_contours(vertices, faces, body)[0] if one.name == "hem")
    assert hem.length < Curve(vertices[hem.vertices]).length - 0.1


@pytest.mark.parametrize("kind", ["tshirt", "long_sleeve_tshirt", "tank", "shorts", "trousers", "jumpsuit"])
def test_a_closed_garment_has_no_front(skin, kind: str) -> None:
    """Breaks where a waist, a neckline or a hem is divided as if it were the border of an open front."""
    body = wearer("stride")
    contours, _ = name_contours(*skin(body, kind), body)
    assert contours
    assert all(contour.is_closed for contour in contours)


def test_a_placket_is_no_hole(skin) -> None:
    """Breaks where a slit at the centre front, as narrow as damage that is bridged, is cut off the neckline."""
    body = wearer("T")
    vertices, faces = skin(body, "tshirt")
    for _ in range(2):
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    neck = next(one for one in name_contours(vertices, faces, body)[0] if one.name == "neck")
    off = vertices[neck.vertices] - body.joint("neck")
    top = off[(np.abs(off[:, 0]) < 0.02) & (off[:, 2] > 0.0), 1].min()
    centres = vertices[faces].mean(axis=1) - body.joint("neck")
    gone = (np.abs(centres[:, 0]) < 0.004) & (centres[:, 1] > top - 0.12) & (centres[:, 2] > 0.0)
    contours, holes = name_contours(vertices, faces[~gone], body, scanned=True)
    found = next(one for one in contours if one.name == "neck")
    assert off[:, 1].min() - (vertices[found.vertices] - body.joint("neck"))[:, 1].min() > 0.08
    assert not any(np.ptp(vertices[hole][:, 1]) > 0.1 for hole in holes)


@pytest.mark.parametrize("place", ["back", "left", "right", "front"])
def test_a_vent_is_no_hole(hung, place: str) -> None:
    """Breaks where a slit at the side or the centre back is cut off the hem, or one elsewhere is not."""
    body = wearer("T")
    vertices, faces = hung(body, 0.6, 0.3, around=96, rows=60)
    off = vertices[faces].mean(axis=1) - body.joint("pelvis")
    along, across = (off[:, 2], off[:, 0]) if place in ("back", "front") else (off[:, 0], off[:, 2])
    sign = -1.0 if place in ("back", "right") else 1.0
    low = vertices[:, 1].min()
    gone = (sign * along > 0.0) & (np.abs(across) < 0.016) & (vertices[faces][:, :, 1].min(axis=1) < low + 0.14)
    contours, holes = name_contours(vertices, faces[~gone], body, scanned=True)
    found = next(one for one in contours if one.name == "hem")
    assert (np.ptp(vertices[found.vertices, 1]) > 0.12) == (place != "front")
    assert any(np.ptp(vertices[hole][:, 1]) > 0.12 for hole in holes) == (place == "front")
