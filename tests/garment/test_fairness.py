"""Corners where a cut is smooth: how large they are, and that fair curves take them away and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.control import update_flat_mesh
from garmentq.core.garment.curves import edge_length, panel_area
from garmentq.core.garment.fairness import SmoothJoin, fair_curves, find_smooth_joins, measure_corner, unplanned_corners
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.judge.fairness import count_waves, measure_fairness

WIDTH, HEIGHT = 0.5, 0.6


def make_skirt(dip: float = 0.0, slant: float = 0.0) -> Pattern:
    """Return a skirt of two equal panels with a control point in the middle of each hem, `dip` [m] below its line.

    With `slant` [m] each hem's ends lie so much higher than its straight line.
    """
    points = np.array(
        [(0.0, slant), (WIDTH / 2, -dip), (WIDTH, slant), (WIDTH, HEIGHT), (0.0, HEIGHT)]
    )  # counter-clockwise from the hem's left end
    edges = tuple(Edge() for _ in points)
    panels = tuple(Panel(name, points, edges) for name in ("front", "back"))
    seams = (
        Seam(EdgeRef("front", 2), EdgeRef("back", 4)),
        Seam(EdgeRef("front", 4), EdgeRef("back", 2)),
    )
    return Pattern("skirt", panels, seams)


def test_corners_are_what_trigonometry_says() -> None:
    """Fails if an angle were halved, measured at a corner of the cut, or not across a seam."""
    found = np.degrees(unplanned_corners(make_skirt(dip=0.02), make_skirt()))
    slope = np.degrees(np.arctan2(0.02, WIDTH / 2))
    # in the middle of each hem, and across each side seam's lower end; the waist stays smooth across its upper ends
    assert sorted(found) == pytest.approx([-2 * slope] * 2 + [0.0] * 2 + [2 * slope] * 2, abs=1e-9)


def test_fair_curves_have_no_corner() -> None:
    """Fails if a corner were left, the points moved far, an area changed, or seams came apart."""
    bent, base = make_skirt(dip=0.02, slant=0.01), make_skirt()
    fair = fair_curves(bent, base)
    assert np.degrees(np.abs(unplanned_corners(bent, base)).max()) > 10.0
    assert np.degrees(np.abs(unplanned_corners(fair, base)).max()) < 0.5
    assert np.abs(fair.points - bent.points).max() < 5e-3
    assert seam_mismatch(fair) < 1e-6
    for before, after in zip(bent.panels, fair.panels, strict=True):
        assert panel_area(after) == pytest.approx(panel_area(before), rel=1e-3)
        assert [edge.kind for edge in after.edges] == ["cubic", "cubic", "line", "line", "line"]


@pytest.mark.parametrize("bent", [4.9, 5.3, 12.0])
def test_what_the_base_pattern_nearly_has_stays_smooth(bent: float) -> None:
    """Fails if a base pattern's corner of 4.8 degrees, with what fairing leaves, came out above 5."""
    base, found = (make_skirt(dip=WIDTH / 2 * np.tan(np.radians(turn / 2))) for turn in (4.8, bent))
    assert np.degrees(unplanned_corners(base, base)).max() == pytest.approx(4.8)
    assert np.degrees(np.abs(unplanned_corners(fair_curves(found, base), base)).max()) <= 5.0


def test_smooth_patterns_stay_as_they_are() -> None:
    """Fails if lines became curves, or a hem's planned corner were smoothed, where nothing is wrong."""
    base, dipped = make_skirt(), make_skirt(dip=0.05)
    assert fair_curves(base, base) is base
    assert fair_curves(dipped, dipped) is dipped
    template = load_template("tshirt")
    assert fair_curves(template, template) is template


def test_straight_seams_stay_straight() -> None:
    """Fails if a sleeve that is set at an angle got a bowed seam on top, or its armhole a corner at the shoulder."""
    base = load_template("tshirt")
    joins = find_smooth_joins(base)
    across = [{name for name, _ in join.corners} for join in joins if join.seam]
    assert {"front", "back"} in across and {"sleeve_front_left", "sleeve_back_left"} in across
    assert {"front", "sleeve_front_left"} not in across
    turned = {}
    for panel in base.panels:
        angle = 0.15 if panel.name in ("sleeve_front_left", "sleeve_back_right") else -0.15
        if "sleeve" in panel.name:
            shear = np.array([[1.0, 0.0], [angle, 1.0]])
            turned[panel.name] = panel.points @ shear.T
    fair = fair_curves(base.with_points(turned), base)
    for seam in base.seams:
        if {seam.a.panel, seam.b.panel} == {"sleeve_front_left", "sleeve_back_left"}:
            kinds = {fair.panel(ref.panel).edges[ref.edge].kind for ref in (seam.a, seam.b)}
            assert kinds == {"line"}


def test_what_is_held_does_not_bend() -> None:
    """Fails if a locked panel were drawn anew: its neighbour has to bend by the whole corner across the seam."""
    bent, base = make_skirt(slant=0.02), make_skirt()
    still = {("front", i) for i in range(5)}
    fair = fair_curves(bent, base, still)
    assert np.array_equal(fair.panel("front").points, bent.panel("front").points)
    assert {edge.kind for edge in fair.panel("front").edges} == {"line"}
    across = [c for c in np.degrees(unplanned_corners(fair, base)) if abs(c) > 0.5]
    assert len(across) == 1  # the front's own middle


@pytest.mark.parametrize("kind", ["quadratic", "cubic", "arc"])
def test_curves_keep_their_course(kind: str) -> None:
    """Fails if a curve that turns at its end became another curve elsewhere."""
    handles = {"quadratic": [(0.5, 0.2)], "cubic": [(0.3, 0.1), (0.7, 0.1)], "arc": [(0.5, 0.1)]}[kind]
    base = make_skirt()
    curved = Edge(kind, np.array(handles, float))
    panels = [replace(panel, edges=(curved, *panel.edges[1:])) for panel in base.panels]
    bent = replace(base, panels=tuple(panels))
    fair = fair_curves(bent, base)
    assert np.degrees(np.abs(unplanned_corners(fair, base)).max()) < 0.5
    for before, after in zip(bent.panels, fair.panels, strict=True):
        assert after.edges[0].kind == "cubic"
        assert edge_length(after, 0) == pytest.approx(edge_length(before, 0), rel=0.05)


def test_the_flat_mesh_follows_its_curves() -> None:
    """Fails if the mesh kept the old outline, a face were turned, or the mesh of the same drawing moved."""
    bent, base = make_skirt(dip=0.02), make_skirt()
    garment = mesh_pattern(bent, 600)
    assert np.abs(update_flat_mesh(garment, bent).uv - garment.uv).max() < 1e-12
    fair = fair_curves(bent, base)
    moved = update_flat_mesh(garment, fair)
    flat = moved.uv[moved.uv_faces]
    sides = flat[:, 1:] - flat[:, :1]
    areas = 0.5 * (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    assert areas.min() > 0.0
    # the outline is a polygon within the curves, whose corners lie on them
    assert areas.sum() == pytest.approx(sum(panel_area(panel) for panel in fair.panels), rel=2e-3)


def test_corners_and_waves_are_metrics() -> None:
    """Fails if a wavy hem counted as a fair one, or the cut's own waves were charged to the recovery."""
    base, bent = make_skirt(), make_skirt(dip=0.02)
    found = measure_fairness(bent, base)
    assert found["pattern.corner_deg"] == pytest.approx(2 * np.degrees(np.arctan2(0.02, WIDTH / 2)))
    assert found["pattern.waves"] == 0.0
    wave = Edge("cubic", np.array([(0.3, 0.2), (0.7, -0.2)]))
    panels = [replace(panel, edges=(wave, *panel.edges[1:])) for panel in base.panels]
    wavy = replace(base, panels=tuple(panels))
    assert count_waves(base.panels[0]) == 0 and count_waves(wavy.panels[0]) == 4  # the S, and the corner after it
    assert measure_fairness(wavy, base)["pattern.waves"] == 8.0
    assert measure_fairness(wavy, wavy)["pattern.waves"] == 0.0


def test_a_corner_that_comes_to_a_point_is_a_metric() -> None:
    """Fails if a corner was charged that the base pattern is cut to, or one that is still a corner of cloth."""
    base = make_skirt()
    length = float(np.ptp(base.panels[0].points[:, 1]))

    def pointed(reach: float) -> Pattern:
        """Return the skirt with one corner of a panel pulled out along its hem."""
        first = base.panels[0]
        points = first.points.copy()
        points[int(np.argmin(points @ [1.0, 1.0]))] -= [reach, 0.0]
        return replace(base, panels=(replace(first, points=points), *base.panels[1:]))

    assert measure_fairness(base, base)["pattern.pointed_corner_deg"] == 0.0
    assert measure_fairness(pointed(0.2 * length), base)["pattern.pointed_corner_deg"] == 0.0
    out = pointed(3.0 * length)
    expected = 90.0 - np.degrees(np.arctan(1.0 / 3.0))
    assert measure_fairness(out, base)["pattern.pointed_corner_deg"] == pytest.approx(expected, abs=1e-6)
    assert measure_fairness(out, out)["pattern.pointed_corner_deg"] == 0.0


def test_a_step_of_two_millimetres_has_no_direction():
    """Broken where a point 2 mm beside a corner, as GarmentCode draws them, has to stay on its line to a degree.

    Moved by 1 mm it is a corner of 30 degrees; turned back, the edges beside it would be bent for what nobody sees.
    """
    points = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.6], [0.002, 0.6], [0.0, 0.6]])
    base = Pattern("step", (Panel("front", points, (Edge(),) * 5),), ())
    graded = base.with_points(points + 1e-3 * np.array([[0, 0], [0, 0], [0, 0], [0, 1], [0, 0]]))
    assert abs(measure_corner(graded, SmoothJoin((("front", 3),)))) > np.radians(20.0)
    assert len(unplanned_corners(graded, base)) == 0
    assert fair_curves(graded, base) is graded
    longer = base.with_points(points + np.array([[0, 0], [0, 0], [0, 0], [0.02, 0], [0, 0]]))
    assert len(find_smooth_joins(longer)) == 1
