"""The shipped base patterns can be cut, sewn and told apart."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import panel_area
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.parts.draft import draft_cut
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.pattern import EdgeRef
from garmentq.core.garment.seams import seam_lengths
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import list_templates, load_draped_template, load_template
from garmentq.core.garment.validity import check_outline
from garmentq.core.run.errors import NotFound
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import CATEGORIES, CONTOUR_NAMES

NAMES = [info.name for info in list_templates()]
CATEGORY = {info.name: info.category for info in list_templates()}

CONTOURS = {
    "tshirt": {"neck", "hem", "cuff.left", "cuff.right"},
    "long_sleeve_tshirt": {"neck", "hem", "cuff.left", "cuff.right"},
    "sleeved_dress": {"neck", "hem", "cuff.left", "cuff.right"},
    "tank": {"neck", "hem", "armhole.left", "armhole.right"},
    "dress": {"neck", "hem", "armhole.left", "armhole.right"},
    "trousers": {"waist", "leg.left", "leg.right"},
    "shorts": {"waist", "leg.left", "leg.right"},
    "skirt": {"waist", "hem"},
    "four_panel_skirt": {"waist", "hem"},
    "pencil_skirt": {"waist", "hem"},
    "jumpsuit": {"neck", "armhole.left", "armhole.right", "leg.left", "leg.right"},
    "sleeved_jumpsuit": {"neck", "cuff.left", "cuff.right", "leg.left", "leg.right"},
}


def sewn_edges(pattern) -> set[EdgeRef]:
    """Return every edge that is part of a seam."""
    return {ref for seam in pattern.seams for ref in (seam.a, seam.b)}


def place(panel) -> np.ndarray:
    """Return a panel's control points in the world [m]."""
    return np.c_[panel.points, np.zeros(len(panel.points))] @ panel.rotation.T + panel.translation


@pytest.mark.parametrize("name", NAMES)
def test_seams_are_equal(name):
    """Breaks where a draft changed one side of a seam only; 0.1 mm is what grading keeps."""
    lengths = seam_lengths(load_template(name))
    assert np.abs(lengths[:, 0] - lengths[:, 1]).max() < 1e-4
    assert lengths.min() > 0.02


@pytest.mark.parametrize("name", NAMES)
def test_left_mirrors_right(name):
    """Breaks where one half was drawn by hand: every panel has a mirror image, itself or another."""
    pattern = load_template(name)
    mirrors = find_symmetry(pattern).mirrors
    assert {i for m in mirrors for i in (m.source, m.target)} == set(range(len(pattern.panels)))
    assert max(np.abs(m.rest).max() for m in mirrors) < 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_sewn_it_has_the_right_openings(name):
    """Breaks where a seam is missing, doubled or twisted: a sphere with k holes has Euler characteristic 2 - k."""
    garment = mesh_pattern(load_template(name), 600)
    edges = np.sort(garment.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, counts = np.unique(edges, axis=0, return_counts=True)
    openings = len(CONTOURS[name])
    assert counts.max() == 2
    assert len(garment.nodes) - len(edges) + len(garment.faces) == 2 - openings
    assert len(find_loops(garment.faces)) == openings


@pytest.mark.parametrize("name", NAMES)
def test_open_edges_and_only_they_carry_contours(name):
    """Breaks where an open edge has no name, or a seam has one."""
    pattern = load_template(name)
    sewn = sewn_edges(pattern)
    for panel in pattern.panels:
        for i, edge in enumerate(panel.edges):
            assert (edge.contour == "") == (EdgeRef(panel.name, i) in sewn)
    named = {edge.contour for panel in pattern.panels for edge in panel.edges} - {""}
    assert named == CONTOURS[name] <= set(CONTOUR_NAMES)
    assert pattern.category == CATEGORY[name] and pattern.category in CATEGORIES


@pytest.mark.parametrize("name", NAMES)
def test_panels_stand_where_they_are_worn(name):
    """Breaks where front and back, left and right or the height are confused on the way through the file."""
    for panel in load_template(name).panels:
        check_outline(panel)
        assert panel_area(panel) > 0
        behind = "back" in panel.name
        assert panel.rotation[:, 2] == pytest.approx([0, 0, -1 if behind else 1], abs=1e-12)
        points = place(panel)
        assert points[:, 2] == pytest.approx(-0.25 if behind else 0.25)
        assert 0.05 < points[:, 1].min() and points[:, 1].max() < 1.5
        if panel.name.endswith(("left", "right")):
            assert (points[:, 0].mean() > 0) == panel.name.endswith("left")
        for i, edge in enumerate(panel.edges):
            if edge.contour.endswith(("left", "right")):
                assert (points[[i, (i + 1) % len(points)], 0].mean() > 0) == edge.contour.endswith("left")


def test_front_necklines_are_deeper_than_back_ones():
    """Breaks where the halves' depths are exchanged."""
    for name in ("tshirt", "long_sleeve_tshirt", "tank", "dress", "sleeved_dress"):
        lowest = {}
        for side in ("front", "back"):
            panel = load_template(name).panel(side)
            height = place(panel)[:, 1]
            lowest[side] = min(height[i] for i, e in enumerate(panel.edges) if e.contour == "neck")
        assert lowest["front"] < lowest["back"] - 0.05


@pytest.mark.parametrize("name", NAMES)
def test_the_files_are_what_the_drafts_give(name):
    """Breaks where a draft was changed and the file was not written again (`write_library`)."""
    drawn, shipped = draft_cut(CUTS[name], name=name), load_template(name)
    assert drawn.points == pytest.approx(shipped.points, abs=1e-9)
    assert [p.name for p in drawn.panels] == [p.name for p in shipped.panels]
    for a, b in zip(drawn.panels, shipped.panels, strict=True):
        assert a.notches == b.notches and a.grainline == b.grainline
        for one, other in zip(a.edges, b.edges, strict=True):
            assert one.kind == other.kind and one.contour == other.contour
            assert one.handles == pytest.approx(other.handles, abs=1e-9)
        assert [e.label for e in a.edges] == [e.label for e in b.edges]


@pytest.mark.parametrize("name", NAMES)
def test_long_seams_are_notched_on_both_sides(name):
    """Breaks where two long edges could be sewn shifted: notches must meet when the seam is closed."""
    pattern = load_template(name)
    notches = {EdgeRef(panel.name, edge): at for panel in pattern.panels for edge, at in panel.notches}
    assert notches
    for seam, (length, _) in zip(pattern.seams, seam_lengths(pattern), strict=True):
        if length > 0.12:
            assert notches[seam.a] == pytest.approx(1.0 - notches[seam.b])
    assert all(np.isfinite(panel.grainline) for panel in pattern.panels)


def test_a_bigger_body_gives_a_bigger_pattern_that_still_sews():
    """Breaks where a length in a draft is fixed that should follow the body."""
    big = BodyMeasures(bust=1.10, waist=0.95, hip=1.15)
    for cut in CUTS.values():
        areas = [sum(panel_area(p) for p in pattern.panels) for pattern in (draft_cut(cut), draft_cut(cut, big))]
        assert areas[1] > 1.05 * areas[0]
        lengths = seam_lengths(draft_cut(cut, big))
        assert np.abs(lengths[:, 0] - lengths[:, 1]).max() < 1e-4


def test_an_unknown_name_lists_the_known_ones():
    """Breaks where a typing error ends in a traceback or in a message without the next step."""
    with pytest.raises(NotFound, match="tshirt, long_sleeve_tshirt, tank, dress") as caught:
        load_template("../tshirt")
    assert caught.value.code == "template.unknown"


@pytest.mark.parametrize("name", NAMES)
def test_each_template_ships_its_drape(name):
    """Breaks where a draft changed and was not draped again: the mesh would not fit, or be stretched out of shape."""
    garment = load_draped_template(name)
    assert garment is not None
    assert {contour.name for contour in garment.contours} == CONTOURS[name]
    edges = np.sort(garment.faces[:, [[0, 1], [1, 2]]].reshape(-1, 2), axis=1)
    worn = np.linalg.norm(garment.nodes[edges[:, 0]] - garment.nodes[edges[:, 1]], axis=1)
    corners = garment.uv_faces[:, [[0, 1], [1, 2]]].reshape(-1, 2)
    flat = np.linalg.norm(garment.uv[corners[:, 0]] - garment.uv[corners[:, 1]], axis=1)
    assert np.median(worn / flat) == pytest.approx(1.0, abs=0.05)
    assert np.quantile(worn / flat, 0.99) < 1.3
    for contour in garment.contours:
        if contour.name.endswith(("left", "right")):
            assert (garment.nodes[contour.vertices, 0].mean() > 0) == contour.name.endswith("left")
