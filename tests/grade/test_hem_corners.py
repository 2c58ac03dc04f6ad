"""The corners of a hem tell where side seams end, and so how wide a front is by its back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.curves import panel_area
from garmentq.core.garment.templates import load_draped_template, load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.grade.hem_corners import share_by_hems
from garmentq.core.scan.contours.target import Target

FLARE = 1.25
"""By how much the hem is made wider: its side seams then slant by 9 degrees, so that it turns by 18 at their ends."""

BODY = builtin_body("builtin:female,height=1.70")


def as_target(garment) -> Target:
    """Return a worn garment as a scan of it."""
    normals = vertex_normals(garment.nodes, garment.faces)
    return Target(garment.nodes, garment.faces, normals, garment.contours, (), garment.pattern.category)


def share(pattern) -> float:
    """Return the front's share of both areas."""
    front, back = (abs(panel_area(pattern.panel(name))) for name in ("front", "back"))
    return front / (front + back)


@pytest.fixture(scope="module")
def flared():
    """Hang a flared skirt with a straight hem on the body: its front takes 0.54 of the girth."""
    base = load_template("pencil_skirt")
    panels = []
    for panel in base.panels:
        points = panel.points * ((1.08 if "front" in panel.name else 0.92), 1.0)
        low = points[:, 1] < points[:, 1].min() + 1e-6
        points[low & ("band" not in panel.name), 0] *= FLARE
        panels.append(replace(panel, points=points))
    return drape_template(
        replace(base, panels=tuple(panels)), WearerGeometry(BODY), settings=DrapeSettings(template_vertices=800)
    )


def test_a_front_is_as_wide_as_the_hem_says(flared):
    """Breaks where the corners are not found, front and back are exchanged, or a waistband is left behind."""
    base = load_template("pencil_skirt")
    found, seen = share_by_hems(base, as_target(flared), BODY)
    assert [each.contour for each in seen] == ["hem"]
    assert seen[0].front == pytest.approx(0.54, abs=0.005)
    assert share(found) == pytest.approx(0.54, abs=0.01)
    assert found.panel("band_front").points[:, 0].max() == pytest.approx(
        1.08 * base.panel("band_front").points[:, 0].max(), rel=0.01
    )
    again, changed = share_by_hems(found, as_target(flared), BODY)
    assert again is found
    assert not changed


def test_noise_hides_corners_but_makes_none(flared):
    """Breaks where a scanner's noise moves the seams: with 1 mm they are found or not, but not elsewhere."""
    rng = np.random.default_rng(0)
    for size in (2e-4, 5e-4, 1e-3):
        noisy = as_target(flared.at(flared.nodes + size * rng.standard_normal(flared.nodes.shape), flared.contours))
        _, seen = share_by_hems(load_template("pencil_skirt"), noisy, BODY)
        assert [each.contour for each in seen] == ["hem"] or (size == 1e-3 and not seen)
        assert all(each.front == pytest.approx(0.54, abs=0.005) for each in seen)


@pytest.mark.parametrize("name", ["skirt", "trousers", "tshirt"])
def test_a_hem_without_corners_changes_nothing(name):
    """Breaks where folds, a dip or a curved hem are taken for corners, or a garment with a neck is shared out anew."""
    base = load_template(name)
    found, seen = share_by_hems(base, as_target(load_draped_template(name)), BODY)
    assert found is base
    assert not seen
