"""Draft skirts."""

from __future__ import annotations

from .division import divide_edges
from .measures import BodyMeasures
from .outline import Outline, Stroke, mirror, place_panel, sew_by_label, smooth, unfold
from .pattern import Pattern


def draft_skirt(measures: BodyMeasures | None = None) -> Pattern:
    """Draft an A-line skirt of two panels from the natural waist to above the knee.

    Allowances: waist + 2 cm (held there), hip + 5 cm, hem 1.30 m wide. Waist and hem dip by 12 and 15 mm at the
    middle, so that both meet the slanted side seams nearly at a right angle and the hem hangs level. Control points at
    every quarter of waist and hem, so that grading can open it to a full circle.
    """
    m = measures or BodyMeasures()
    waist, hip = (m.waist + 0.02) / 4, (m.hip + 0.05) / 4
    points = [(0.325, -0.54), (hip, m.hip_height - m.waist_height), (waist, 0.0)]
    strokes = smooth(points, ["side.0.left", "side.1.left"])
    strokes.append(Stroke((0.0, -0.012), ((waist * 0.6, -0.010), (waist * 0.3, -0.012)), contour="waist"))
    outline = unfold(Outline(points[0], tuple(strokes)), "hem", dip=0.015)
    panels = [place_panel(side, outline, m.waist_height) for side in ("front", "back")]
    return divide_edges(divide_edges(sew_by_label("skirt", "skirt", panels), {"hem"}, 4), {"waist"}, 2)


def draft_four_panel_skirt(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a knee-length A-line skirt of four panels, flared at the sides and at the centre seams alike.

    Allowances: waist + 2 cm (held there), hip + 6 cm, hem 1.72 m wide; a third of each panel's flare lies at the centre
    seam, so that the hem falls in folds all around.
    """
    m = measures or BodyMeasures()
    waist, hip = (m.waist + 0.02) / 4, (m.hip + 0.06) / 4
    hip_line = m.hip_height - m.waist_height
    points = [(0.37, -0.58), (hip, hip_line), (waist, 0.0)]
    outline = Outline(
        points[0],
        (
            *smooth(points, ["side.0.left", "side.1.left"]),
            Stroke((0.0, -0.010), ((waist * 0.6, -0.009), (waist * 0.3, -0.010)), contour="waist"),
            Stroke((0.0, hip_line), label="centre.0"),
            Stroke((-0.06, -0.60), label="centre.1"),
            Stroke(points[0], contour="hem"),
        ),
    )
    panels = []
    for side in ("front", "back"):
        named = Outline(outline.start, tuple(_on_centre(s, side) for s in outline.strokes))
        panels.append(place_panel(f"{side}_left", named, m.waist_height))
        panels.append(place_panel(f"{side}_right", mirror(named), m.waist_height))
    return divide_edges(sew_by_label("four_panel_skirt", "skirt", panels), {"hem"}, 2)


def _on_centre(stroke: Stroke, side: str) -> Stroke:
    """Tell the front's centre seam from the back's."""
    if not stroke.label.startswith("centre"):
        return stroke
    return Stroke(stroke.end, stroke.handles, stroke.label.replace("centre", f"centre.{side}"), notch=stroke.notch)


def draft_pencil_skirt(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a pencil skirt with a waistband: front, back and two halves of the band.

    Allowances: waist + 2 cm, hip + 4 cm, above the knee, where the hem is 6 cm narrower than the hip line; a band
    of 4 cm, long enough to be as stiff as two layers of cloth and short enough to follow the waist.
    """
    m = measures or BodyMeasures()
    waist, hip = (m.waist + 0.02) / 4, (m.hip + 0.04) / 4
    points = [(hip - 0.015, -0.50), (hip, m.hip_height - m.waist_height), (waist, 0.0)]
    panels = []
    for side in ("front", "back"):
        seam = Stroke((0.0, 0.0), label=f"band.{side}.left")
        outline = unfold(Outline(points[0], (*smooth(points, ["side.0.left", "side.1.left"]), seam)), "hem")
        panels.append(place_panel(side, outline, m.waist_height))
        band = Outline(
            (-waist, 0.0),
            (
                Stroke((0.0, 0.0), label=f"band.{side}.right"),
                Stroke((waist, 0.0), label=f"band.{side}.left"),
                Stroke((waist, 0.04), label="bandside.left"),
                Stroke((-waist, 0.04), contour="waist"),
                Stroke((-waist, 0.0), label="bandside.right"),
            ),
        )
        panels.append(place_panel(f"band_{side}", band, m.waist_height, label="band"))
    panels.sort(key=lambda panel: panel.name.startswith("band"))
    return sew_by_label("pencil_skirt", "skirt", panels)
