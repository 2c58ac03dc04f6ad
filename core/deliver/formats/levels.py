"""Find where bust, waist and hips of the wearer lie on the panels of a garment."""

from __future__ import annotations

import numpy as np

from ...body.body import JOINTS, Body
from ...body.girths import BELOW_ARMPIT
from ...garment.measures import BodyMeasures
from ...garment.orientation import place_points
from ...garment.panel_parts import find_arm_panels, find_part
from ...garment.pattern import Panel, Pattern
from ...garment.pieces.marked_lines import PanelLevel
from ...garment.pieces.seam_names import name_seam

BANDED_PARTS = ("collar", "hood", "cuff", "band", "wb")
"""Parts of a garment on which no body line is drawn."""

MIN_LEVEL_PANEL_SHARE = 0.5
"""Smallest share of the vertical that lies in an upright panel's plane, squared: a flatter one has no level."""


def find_levels(pattern: Pattern, measures: BodyMeasures, hang_height: float | None = None) -> tuple[PanelLevel, ...]:
    """Return where the levels of bust, waist and hips lie on each panel of trunk and legs, as a pattern maker measures
    them: down from the side neck point of a garment with shoulder seams, or from the waist of one that hangs there. A
    garment with neither has none. How high the cloth hangs in a pose is not asked: raised arms lift it.

    Args:
        pattern: The pattern, its panels placed on the body.
        measures: The wearer's.
        hang_height: Height above the feet at which a garment without shoulders hangs [m]; None: the waist's.
    """
    arms = find_arm_panels(pattern)
    panels = [panel for panel in pattern.panels if panel.name not in arms and find_part(panel) not in BANDED_PARTS]
    hang_height = measures.waist_height if hang_height is None else hang_height
    feet = _find_feet(pattern, panels, measures.nape_height, hang_height)
    if feet is None:
        return ()
    heights = {
        "bust": measures.armpit_height - BELOW_ARMPIT,
        "waist": measures.waist_height,
        "hip": measures.hip_height,
    }
    return tuple(
        PanelLevel(name, panel.name, point)
        for panel in panels
        for name, height in heights.items()
        if (point := _find_point(panel, feet + height)) is not None
    )


def find_hang_height(waist: np.ndarray | None, body: Body) -> float | None:
    """Return the height above the feet at which a worn garment hangs [m], as in the body's T-pose; None without a
    curve, shape [n, 3] [m], from which it hangs."""
    if waist is None:
        return None
    pelvis = JOINTS.index("pelvis")
    return float(waist[:, 1].mean() - body.joints[pelvis, 1] + body.rest_joints[pelvis, 1])


def _find_feet(pattern: Pattern, panels: list[Panel], nape_height: float, hang_height: float) -> float | None:
    """Return the height of the wearer's feet where the pattern's panels are placed [m]; None where nothing shows it."""
    placed = {panel.name: place_points(panel, panel.points)[:, 1] for panel in panels}
    named = {name_seam(pattern, seam).name: seam for seam in pattern.seams}
    if "shoulder seam" in named:
        return max(float(heights.max()) for heights in placed.values()) - nape_height
    at_waist = [
        float(placed[panel.name][[i, (i + 1) % len(panel.edges)]].mean())
        for panel in panels
        for i, edge in enumerate(panel.edges)
        if edge.contour == "waist"
    ]
    at_waist += [
        float(placed[ref.panel][[ref.edge, (ref.edge + 1) % len(placed[ref.panel])]].mean())
        for seam in pattern.seams
        if name_seam(pattern, seam).name == "waistband seam"
        for ref in (seam.a, seam.b)
        if ref.panel in placed
    ]
    return float(np.mean(at_waist)) - hang_height if at_waist else None


def _find_point(panel: Panel, height: float) -> np.ndarray | None:
    """Return the point of a panel's own axes at a height of its place, below or above its middle [m], shape [2]; None
    where it does not reach so far."""
    up, middle = panel.rotation[1, :2], panel.points.mean(axis=0)
    placed = place_points(panel, panel.points)[:, 1]
    if up @ up < MIN_LEVEL_PANEL_SHARE or not placed.min() < height < placed.max():
        return None
    found: np.ndarray = middle + up * (height - middle @ up - panel.translation[1]) / (up @ up)
    return found
