"""Operations of a pattern maker against what anybody can measure."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_length, panel_area, panel_outline
from garmentq.core.garment.editing.cutting import cut_panel
from garmentq.core.garment.editing.edge_division import merge_edges, split_edges
from garmentq.core.garment.editing.errors import EditBad
from garmentq.core.garment.editing.joining import join_panels
from garmentq.core.garment.editing.move_points import move_points
from garmentq.core.garment.editing.operations import apply_operations
from garmentq.core.garment.editing.reshaping import sharpen_corner, smooth_corner, straighten_edges
from garmentq.core.garment.examine import find_faults
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.seams import seam_lengths, seam_mismatch
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import load_template

KINDS = [
    Edge("line"),
    Edge("quadratic", np.array([[0.4, 0.3]])),
    Edge("cubic", np.array([[0.2, 0.3], [0.7, -0.2]])),
    Edge("arc", np.array([[0.5, 0.2]])),
    Edge("arc", np.array([[0.5, -0.3]])),
]


@pytest.fixture(scope="module")
def tshirt() -> Pattern:
    """Return the T-shirt of the library."""
    return load_template("tshirt")


def square(edge: Edge = Edge()) -> Pattern:  # noqa: B008 - frozen
    """Return a square of 1 m whose lowest edge is some curve, sewn on its right to another one of lines."""
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    one = Panel("one", points, (edge, Edge(), Edge(), Edge()), notches=((0, 0.25), (1, 0.5)))
    other = Panel("other", points, (Edge(),) * 4, translation=np.array([1.5, 0.0, 0.3]))
    return Pattern("squares", (one, other), (Seam(EdgeRef("one", 1), EdgeRef("other", 3)),), symmetric=False)


def perimeter(panel: Panel) -> float:
    """Return the length of a panel's outline [m]."""
    return sum(edge_length(panel, i) for i in range(len(panel.edges)))


def test_moved_point_takes_mirror_and_seam_along(tshirt):
    """Broken where a point does not move by exactly what is asked, or its image or the sewn point stays behind."""
    way = np.array([0.01, -0.02])
    edited = move_points(tshirt, [("front", 0)], way)
    moved = {name: edited.panel(name).points - tshirt.panel(name).points for name in ("front", "back")}
    np.testing.assert_allclose(moved["front"][0], way, atol=1e-12)
    np.testing.assert_allclose(moved["front"][8], way * [-1, 1], atol=1e-12)
    np.testing.assert_allclose(moved["back"][[0, 1], 1], -0.02, atol=2e-3)
    assert seam_mismatch(edited) < 1e-6
    symmetry = find_symmetry(edited)
    assert len(symmetry.mirrors) == len(find_symmetry(tshirt).mirrors)
    alone = move_points(tshirt, [("front", 0)], way, keep_symmetry=False, keep_seams=False)
    assert np.count_nonzero(np.abs(alone.points - tshirt.points) > 1e-12) == 2


def test_hem_widened_in_front_and_back(tshirt):
    """Broken where 20 mm more in front and in the back are not 40 mm of hem, or the seams differ."""
    wider = tshirt
    for name, corner in (("front", 0), ("back", 1)):
        wider = move_points(wider, [(name, corner)], np.array([0.01, 0.0]))
    hem = [edge_length(p.panel("front"), 8) + edge_length(p.panel("back"), 0) for p in (tshirt, wider)]
    assert hem[1] - hem[0] == pytest.approx(0.040, abs=1e-4) and seam_mismatch(wider) < 1e-6


@pytest.mark.parametrize("edge", KINDS, ids=[f"{e.kind}{i}" for i, e in enumerate(KINDS)])
@pytest.mark.parametrize("at", [0.2, 0.5])
def test_split_and_merged_is_the_same_curve(edge, at):
    """Broken where a control point more changes the outline, or taking it away does not bring the curve back."""
    start = square(edge)
    divided = split_edges(start, "one", 0, at)
    one = divided.panel("one")
    assert len(one.points) == 5 and divided.seams[0].a == EdgeRef("one", 2)
    assert edge_length(one, 0) == pytest.approx(at * edge_length(start.panel("one"), 0), abs=1e-9)
    assert perimeter(one) == pytest.approx(perimeter(start.panel("one")), abs=1e-9)
    assert panel_area(one) == pytest.approx(panel_area(start.panel("one")), abs=2e-4)
    merged = merge_edges(divided, "one", 1).panel("one")
    assert merged.edges[0].kind == edge.kind
    np.testing.assert_allclose(merged.edges[0].handles, edge.handles, atol=1e-6)
    assert [number for number, _ in merged.notches] == [0, 1]
    np.testing.assert_allclose([f for _, f in merged.notches], [0.25, 0.5], atol=1e-9)


def test_split_of_a_sewn_edge_splits_the_seam(tshirt):
    """Broken where the halves of a seam are not sewn to each other, or mirror images are forgotten."""
    divided = split_edges(tshirt, "front", 0, 0.3)
    assert len(divided.seams) == len(tshirt.seams) + 2 and seam_mismatch(divided) < 1e-9
    assert not find_faults(divided)
    assert len(divided.panel("front").points) == len(divided.panel("back").points) == 11
    merged = merge_edges(divided, "front", 1)
    assert len(merged.seams) == len(tshirt.seams) and seam_mismatch(merged) < 1e-9
    np.testing.assert_allclose(merged.panel("back").points, tshirt.panel("back").points, atol=1e-9)
    assert {(s.a, s.b) for s in merged.seams} == {(s.a, s.b) for s in tshirt.seams}


def test_merge_of_any_corner_keeps_the_length(tshirt):
    """Broken where the edge in place of two others that are no parts of one curve is of another length."""
    merged = merge_edges(square(KINDS[2]), "one", 0)
    before = square(KINDS[2]).panel("one")
    assert edge_length(merged.panel("one"), 2) == pytest.approx(
        edge_length(before, 3) + edge_length(before, 0), abs=1e-6
    )
    with pytest.raises(EditBad) as caught:
        merge_edges(tshirt, "front", 1, keep_symmetry=False)
    assert caught.value.places[0].vertex == 1


def test_straightened_edges_are_lines(tshirt):
    """Broken where a curve between two points stays one, the way round is the longer one, or a mirror image stays."""
    edited = straighten_edges(tshirt, "front", 2, 1)
    assert edited.panel("front").edges[1].kind == edited.panel("front").edges[6].kind == "line"
    assert edited.panel("front").edges[3].kind == "cubic" and seam_mismatch(edited) < 1e-6
    alone = straighten_edges(square(KINDS[1]), "one", 0, 1).panel("one")
    assert perimeter(alone) == pytest.approx(4.0) and panel_area(alone) == pytest.approx(1.0)


def test_corner_to_curve_and_back():
    """Broken where a corner that is made smooth still turns, its end directions change, or the way back is no line."""
    start = square()
    round_ = smooth_corner(start, "one", 0).panel("one")
    outline = panel_outline(round_, 400)
    at = int(np.argmin(np.linalg.norm(outline, axis=1)))
    before, after = outline[at] - outline[at - 1], outline[(at + 1) % len(outline)] - outline[at]
    turn = np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after)
    assert abs(turn) < 0.02
    assert np.arctan2(after[1], after[0]) == pytest.approx(-np.pi / 4, abs=0.02)
    back = sharpen_corner(smooth_corner(start, "one", 0), "one", 0)
    assert [edge.kind for edge in back.panel("one").edges] == ["line"] * 4
    kept = smooth_corner(start, "one", 0).panel("one").edges[0].handles[1]
    np.testing.assert_allclose(kept, [2 / 3, 0.0], atol=1e-12)


def test_cut_makes_a_seam_and_loses_nothing(tshirt):
    """Broken where the pieces are not the panel, the new seam's sides differ, or what was sewn to an edge is not."""
    cut = cut_panel(tshirt, "front", np.array([[-0.4, -0.4], [0.4, -0.35]]))
    names = [panel.name for panel in cut.panels]
    assert names[1:3] == ["front", "front_2"] and len(names) == 7
    area = panel_area(cut.panel("front")) + panel_area(cut.panel("front_2"))
    assert area == pytest.approx(panel_area(tshirt.panel("front")), rel=1e-6)
    assert len(cut.seams) == len(tshirt.seams) + 3 and seam_mismatch(cut) < 1e-9
    assert seam_lengths(cut)[-1] == pytest.approx(np.hypot(0.51, 0.51 * 0.05 / 0.8), abs=1e-9)
    assert not find_faults(cut)
    joined = join_panels(cut, len(cut.seams) - 1)
    assert panel_area(joined.panel("front")) == pytest.approx(panel_area(tshirt.panel("front")), rel=1e-6)
    assert [panel.name for panel in joined.panels] == [panel.name for panel in tshirt.panels]
    assert not find_faults(joined) and seam_mismatch(joined) < 1e-9
    assert perimeter(joined.panel("front")) == pytest.approx(perimeter(tshirt.panel("front")), abs=1e-6)


def test_cut_through_corners_needs_no_new_points():
    """Broken where a cut from corner to corner makes edges without length."""
    cut = cut_panel(square(), "one", np.array([[-0.1, -0.1], [1.1, 1.1]]))
    assert sorted(len(panel.points) for panel in cut.panels) == [3, 3, 4]
    assert panel_area(cut.panels[0]) == pytest.approx(0.5)
    assert seam_lengths(cut)[-1] == pytest.approx([np.sqrt(2.0)] * 2)
    for line in ([[-0.1, 0.5], [0.5, 0.5]], [[2.0, 0.0], [2.0, 1.0]], [[-0.1, 0.0], [1.1, 0.0]]):
        with pytest.raises(EditBad):
            cut_panel(square(), "one", np.array(line))


def test_join_is_the_sum_of_both():
    """Broken where two squares joined are no rectangle of 2 m2, whichever way one was turned."""
    turned = square()
    joined = join_panels(turned, 0)
    assert len(joined.panels) == 1 and joined.seams == () and panel_area(joined.panels[0]) == pytest.approx(2.0)
    assert perimeter(joined.panels[0]) == pytest.approx(6.0)
    assert np.ptp(joined.panels[0].points, axis=0) == pytest.approx([2.0, 1.0])


def test_join_is_refused_where_it_cannot_be(tshirt):
    """Broken where a curved seam is joined, or the refusal does not name the seam."""
    with pytest.raises(EditBad) as caught:
        join_panels(tshirt, 1)
    assert caught.value.seam == 1 and {place.panel for place in caught.value.places} == {"back", "sleeve_back_right"}


def test_operations_are_the_functions(tshirt):
    """Broken where a list of operations does something else than the functions, or an unknown one passes."""
    done = apply_operations(
        tshirt,
        [
            {"op": "move", "points": [{"panel": "front", "vertex": 0}], "by_mm": [10, -20]},
            {"op": "split", "panel": "front", "edge": 8, "at": 0.5},
            {"op": "cut", "panel": "back", "line_mm": [[-400, -400], [400, -400]]},
        ],
    )
    wanted = split_edges(move_points(tshirt, [("front", 0)], np.array([0.01, -0.02])), "front", 8, 0.5)
    wanted = cut_panel(wanted, "back", np.array([[-0.4, -0.4], [0.4, -0.4]]))
    np.testing.assert_allclose(done.points, wanted.points, atol=1e-12)
    assert "back_2" in [panel.name for panel in done.panels] and not find_faults(done)
    for wrong in (
        {"op": "fold"},
        {"op": "join"},
        {"op": "join", "seam": 99},
        {"op": "split", "panel": "front", "edge": 99},
        {"op": "split", "panel": "hood", "edge": 0},
        {"op": "move", "points": [], "by_mm": [0, 0], "colour": 1},
        {"op": "move", "points": [{"panel": "front", "vertex": 0}], "by_mm": [0, "x"]},
    ):
        with pytest.raises(Exception, match="operation 0") as caught:
            apply_operations(tshirt, [wrong])
        assert getattr(caught.value, "code", "").startswith("pattern.")
