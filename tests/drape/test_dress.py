"""The first drape: every shipped template hangs on the built-in body, whole and outside it."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
import pytest
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import list_templates, load_template
from garmentq.core.recover.drape.dress import place_panels
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.waist import waist_loop
from garmentq.core.recover.drape.wearer import WearerGeometry
from wearers import find_wearer

CONTOURS = {
    "tshirt": {"neck", "cuff.left", "cuff.right", "hem"},
    "tank": {"neck", "armhole.left", "armhole.right", "hem"},
    "dress": {"neck", "armhole.left", "armhole.right", "hem"},
    "trousers": {"waist", "leg.left", "leg.right"},
    "skirt": {"waist", "hem"},
    "long_sleeve_tshirt": {"neck", "cuff.left", "cuff.right", "hem"},
    "sleeved_dress": {"neck", "cuff.left", "cuff.right", "hem"},
    "shorts": {"waist", "leg.left", "leg.right"},
    "four_panel_skirt": {"waist", "hem"},
    "pencil_skirt": {"waist", "hem"},
    "jumpsuit": {"neck", "armhole.left", "armhole.right", "leg.left", "leg.right"},
    "sleeved_jumpsuit": {"neck", "cuff.left", "cuff.right", "leg.left", "leg.right"},
}


@cache
def wearer_in(pose: str) -> WearerGeometry:
    """Return the built-in body in a pose with its distance grids."""
    return find_wearer("builtin:female,height=1.70" + (f",pose={pose}" if pose != "T" else ""))


FINER = (("trousers", "T"), ("sleeved_dress", "A"))
"""Templates and poses of the suite at this density, one that hangs from the waist and one with arms; `test_poses` tries
all at half of it. The others are nightly."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "pose"),
    [
        pytest.param(*case, marks=() if case in FINER else pytest.mark.nightly)
        for case in product(sorted(CONTOURS), ("T", "A"))
    ],
)
def test_template_hangs_on_the_builtin_body(name: str, pose: str) -> None:
    """Breaks if a panel passes through the body while it is inflated, or if the pose tears the cloth."""
    wearer = wearer_in(pose)
    garment = drape_template(load_template(name), wearer, settings=DrapeSettings(template_vertices=700))
    assert {contour.name for contour in garment.contours} == CONTOURS[name]
    assert wearer.grid.distance(garment.nodes).min() > -1e-3
    sides = garment.faces[:, [[0, 1], [1, 2], [2, 0]]]
    rest = garment.rest[:, [[0, 1], [1, 2], [2, 0]]]
    ratio = np.linalg.norm(np.diff(garment.nodes[sides], axis=2), axis=-1) / np.linalg.norm(
        np.diff(rest, axis=2), axis=-1
    )
    assert 0.9 < np.median(ratio) < 1.1
    assert np.quantile(ratio, 0.99) < 2.0


def test_every_template_is_tried_here() -> None:
    """Breaks if a template is shipped that no test drapes."""
    assert {info.name for info in list_templates()} == set(CONTOURS)


@pytest.mark.parametrize("shift", [-1.1, 0.0, 0.4])
def test_origin_of_the_file_does_not_matter(shift: float) -> None:
    """Breaks if the height at which a garment is placed follows its file instead of the body's shoulders or waist."""
    body = wearer_in("T").rest
    for name in ("tshirt", "skirt"):
        garment = mesh_pattern(load_template(name), 500)
        moved = garment.at(garment.nodes + np.array([0.3, shift, -0.2]))
        assert place_panels(moved, body) == pytest.approx(place_panels(garment, body), abs=1e-9)


def test_only_garments_without_arms_hang_from_the_waist() -> None:
    """Breaks if a top is held at its neck as if that were a waistband."""
    held = {name: waist_loop(mesh_pattern(load_template(name), 500)) is not None for name in CONTOURS}
    assert held == {name: "waist" in contours for name, contours in CONTOURS.items()}


@pytest.mark.parametrize(("name", "below"), [("trousers", 0.06), ("skirt", 0.0)])
def test_waistband_sits_where_the_body_is_as_wide(name: str, below: float) -> None:
    """Breaks if a waist without a target is over 5 cm off: 0 or 6 cm below the natural waist (1.07 m)."""
    garment = mesh_pattern(load_template(name), 500)
    waist = waist_loop(garment)
    assert waist is not None
    nodes = place_panels(garment, wearer_in("T").rest)
    assert nodes[waist, 1].mean() == pytest.approx(1.07 - below, abs=0.05)
