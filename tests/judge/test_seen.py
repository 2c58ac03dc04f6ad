"""Cloth that a scan does not show is found, and only that."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.creases import mark_turned_faces
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import face_areas
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.judge.seen import find_seen_faces, measure_inferred_area
from garmentq.core.recover.drape.stage import drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry


@pytest.fixture(scope="module")
def shirt() -> Garment:
    """Return a shirt, its collar turned."""
    wearer = WearerGeometry(builtin_body("builtin:female,height=1.70"))
    return drape_template(load_template("tshirt+collar=shirt,front=buttons"), wearer)


def test_all_of_a_whole_scan_is_seen(shirt: Garment) -> None:
    """Breaks where the cloth along an end of the scan, or below a fall that was scanned on both sides, is dropped."""
    seen = find_seen_faces(shirt, TriangleSurface(shirt.nodes, shirt.faces))
    assert seen.all()
    assert set(measure_inferred_area(shirt, seen).values()) == {0.0}


def test_cloth_over_a_hole_and_beyond_an_end_is_inferred(shirt: Garment) -> None:
    """Breaks where cloth that a scanner missed counts as seen, or more than that as inferred."""
    centres = shirt.nodes[shirt.faces].mean(axis=1)
    chest = shirt.nodes[np.argmax(shirt.nodes[:, 2])]
    missed = (np.linalg.norm(centres - chest, axis=1) < 0.08) | (centres[:, 1] < shirt.nodes[:, 1].min() + 0.1)
    seen = find_seen_faces(shirt, TriangleSurface(shirt.nodes, shirt.faces[~missed]))
    assert np.array_equal(seen, ~missed)
    shares, areas = measure_inferred_area(shirt, seen), face_areas(shirt.nodes, shirt.faces)
    for index, panel in enumerate(shirt.pattern.panels):
        own = shirt.panel_of_face == index
        assert shares[panel.name] == pytest.approx(areas[own & missed].sum() / areas[own].sum())


def test_what_a_fall_covers_is_inferred(shirt: Garment) -> None:
    """Breaks where the stand below a collar, which a person's scan cannot show, counts as seen."""
    turned = mark_turned_faces(shirt)
    over = TriangleSurface(shirt.nodes, shirt.faces[turned])
    below = over.distance(shirt.nodes[shirt.faces].mean(axis=1)) < 0.01
    faces = np.concatenate([shirt.faces[~turned & ~below], shirt.faces[turned][:, ::-1]])
    seen = find_seen_faces(shirt, TriangleSurface(shirt.nodes, faces))
    assert seen[turned].all() and seen[~turned & ~below].mean() > 0.95
    shares = measure_inferred_area(shirt, seen)
    assert shares["collar_back"] > 0.5 > max(shares["front_left"], shares["sleeve_front_left"])
