"""A scan of the outside alone shows a fall's inner side and nothing below it; what it shows is fitted."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.garment.creases import mark_turned_faces, turned_area
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.shown_sides import find_shown_sides, select_shown_faces
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.recover.deform.deformer import deform
from garmentq.core.recover.drape.stage import drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.contours.target import Target
from garmentq.core.scan.contours.turned import free_covered_neck

BODY = builtin_body("builtin:female,height=1.70")


@pytest.fixture(scope="module")
def shirt() -> Garment:
    """Return a shirt, its collar turned."""
    return drape_template(load_template("tshirt+collar=shirt,front=buttons"), WearerGeometry(BODY))


@pytest.fixture(scope="module")
def outside(shirt: Garment) -> Target:
    """Return what a scanner shows of it from outside: the fall, and the shirt but for what lies below that."""
    turned = mark_turned_faces(shirt)
    over = TriangleSurface(shirt.nodes, shirt.faces[turned])
    below = over.distance(shirt.nodes[shirt.faces].mean(axis=1)) < 0.01
    faces = np.concatenate([shirt.faces[~turned & ~below], shirt.faces[turned][:, ::-1]])
    contours, _ = name_contours(shirt.nodes, faces, BODY)
    return Target(shirt.nodes, faces, vertex_normals(shirt.nodes, faces), contours, (), "tshirt")


def test_sides_follow_what_a_scan_shows(shirt: Garment, outside: Target) -> None:
    """Breaks where a garment that was scanned on both sides loses its stand, or a fused surface keeps it."""
    turned, nodes = mark_turned_faces(shirt), shirt.nodes
    both = find_shown_sides(shirt, TriangleSurface(nodes, shirt.faces), vertex_normals(nodes, shirt.faces))
    assert (both == 1).all()
    assert np.array_equal(select_shown_faces(shirt.faces, both), shirt.faces)
    for sign in (1.0, -1.0):
        sides = find_shown_sides(shirt, TriangleSurface(nodes, outside.faces), sign * outside.normals)
        assert (sides[turned] == -1).all() and (sides[~turned] >= 0).all()
        stand = [i for i, panel in enumerate(shirt.pattern.panels) if panel.name.startswith("collar")]
        is_stand = np.isin(shirt.panel_of_face, stand) & ~turned
        assert (sides[is_stand] == 0).mean() > 0.6 and (sides[~turned & ~is_stand] == 1).mean() > 0.8


def test_a_fall_is_fitted_by_its_inner_side(shirt: Garment, outside: Target) -> None:
    """Breaks where the edge of a fall is drawn to the border behind its crease, or the fall to the wrong side."""
    target = free_covered_neck(outside, BODY, turned_area(shirt.pattern))
    neck = target.contour("neck")
    assert neck is None or not neck.trusted
    lower = shirt.at(shirt.nodes + np.array([0.0, -0.004, 0.006]))
    fitted = deform(lower, target, ExposedSurface.of(BODY))
    turned = shirt.faces[mark_turned_faces(shirt)]
    off = TriangleSurface(shirt.nodes, turned).distance(fitted.nodes[np.unique(turned)])
    assert np.sqrt((off**2).mean()) < 0.007  # 5 mm; drawn to the border 8, with the wrong side 23
    assert fitted.flipped_faces[1] == fitted.self_intersecting_faces[1] == 0
