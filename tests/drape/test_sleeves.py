"""Sleeves drafted for hanging arms are laid along the arms before a T-pose is dressed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import list_templates, load_template
from garmentq.core.recover.drape.dress import SHOULDER_LIFT_HEIGHT
from garmentq.core.recover.drape.sleeves import turn_sleeves
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template, has_hanging_sleeves
from wearers import find_wearer


def hang_sleeves(pattern: Pattern, angle: float) -> Pattern:
    """Turn a shirt's sleeves down about the shoulders' tips, 19 cm out and 1.40 m high, and set them 5 cm apart."""
    panels = []
    for panel in pattern.panels:
        if panel.label == "sleeve":
            side = -1.0 if panel.name.endswith("right") else 1.0
            turn = -side * angle
            down = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
            tip = np.array([0.19 * side, 1.40, 0.0])
            at = down @ (panel.translation - tip) + tip + [0.05 * side, 0.0, 0.0]
            panel = replace(panel, rotation=down @ panel.rotation, translation=at)
        panels.append(panel)
    return replace(pattern, panels=tuple(panels))


def test_hanging_sleeves_are_put_over_the_arms() -> None:
    """Breaks if sleeves that are placed for an A-pose start beside the stretched arms: the arms miss the cuffs."""
    pattern = hang_sleeves(load_template("long_sleeve_tshirt"), np.radians(50.0))
    worn = drape_template(pattern, find_wearer(), settings=DrapeSettings(template_vertices=500))
    assert [contour.name for contour in worn.contours] == ["cuff.left", "cuff.right", "hem", "neck"]


@pytest.mark.parametrize("name", [info.name for info in list_templates()])
def test_what_is_no_hanging_sleeve_stays(name: str) -> None:
    """Breaks if legs, skirts or sleeves that already lie along the arms are turned."""
    garment = mesh_pattern(load_template(name), 350)
    rotation, origin = turn_sleeves(garment, find_wearer().body, SHOULDER_LIFT_HEIGHT)
    assert np.array_equal(rotation, [panel.rotation[:2, :2] for panel in garment.pattern.panels])
    assert np.array_equal(origin, [panel.translation[:2] for panel in garment.pattern.panels])


@pytest.mark.parametrize("scale", [1.5, 2.0])
def test_a_wide_drooping_sleeve_is_put_over_the_arm(scale: float) -> None:
    """Breaks if the arm starts above the sleeve's upper seam: it then comes out through the cloth beside the cuff."""
    shirt = load_template("tshirt")
    panels = tuple(replace(panel, translation=scale * panel.translation) for panel in shirt.panels)
    garment = mesh_pattern(replace(shirt, panels=panels).with_points(scale * shirt.points), 350)
    rotation, origin = turn_sleeves(garment, find_wearer().body, SHOULDER_LIFT_HEIGHT)
    turned = np.abs(rotation - [panel.rotation[:2, :2] for panel in garment.pattern.panels]).max(axis=(1, 2)) > 0.1
    assert [panel.label == "sleeve" for panel in garment.pattern.panels] == turned.tolist()
    of = garment.panel_of_uv
    height = (np.einsum("nij,nj->ni", rotation[of], garment.uv) + origin[of])[:, 1]
    left = np.array(["sleeve" in panel.name and "left" in panel.name for panel in garment.pattern.panels])[of]
    cuff = np.concatenate(
        [
            line
            for ref, line in garment.edge_uv.items()
            if garment.pattern.panel(ref.panel).edges[ref.edge].contour == "cuff.left"
        ]
    )
    assert height[left].max() - height[cuff].max() <= SHOULDER_LIFT_HEIGHT + 1e-9


def test_the_side_panel_of_a_bodice_is_no_sleeve() -> None:
    """Breaks if any panel beyond a shoulder with an opening of its own is laid along the arm: here, its armhole."""
    bodice = load_template("dress+shaping=princess,waist=seam")
    out = {"left": np.array([0.12, 0.0, 0.0]), "right": np.array([-0.12, 0.0, 0.0])}
    panels = tuple(
        replace(panel, translation=panel.translation + out[panel.name.rpartition("_")[2]])
        if "_side_" in panel.name and not panel.name.startswith("skirt")
        else panel
        for panel in bodice.panels
    )
    garment = mesh_pattern(replace(bodice, panels=panels), 350)
    rotation, _ = turn_sleeves(garment, find_wearer().body, SHOULDER_LIFT_HEIGHT)
    assert np.array_equal(rotation, [panel.rotation[:2, :2] for panel in garment.pattern.panels])


@pytest.mark.parametrize(
    ("pose", "ends", "hangs"),
    [("arms-down", "cuff.left", True), ("arms-down", "armhole.left", False), ("A", "cuff.left", False)],
)
def test_sleeves_hang_on_arms_that_hang(pose: str, ends: str, hangs: bool) -> None:
    """Broken where every T-shirt pays for cloth kept apart in its graded drape, or one with hanging arms does not."""
    target = SimpleNamespace(contours=[SimpleNamespace(name=ends)])
    assert has_hanging_sleeves(target, builtin_body(f"builtin:female,pose={pose}")) == hangs
