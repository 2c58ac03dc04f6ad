"""Meshing and sewing: seams agree, the surface is a manifold of the right kind, triangles are good."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_points, panel_area
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.meshing import corner_angles
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.run.errors import BadInput
from hypothesis import given, settings
from hypothesis import strategies as st


def _edges(faces):
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def _topology(garment):
    """Return Euler characteristic and number of boundary loops, and check that the mesh is an oriented manifold."""
    directed = _edges(garment.faces)
    assert len(np.unique(directed, axis=0)) == len(directed), "an edge is run twice the same way"
    edges, counts = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    assert counts.max() <= 2
    rim = edges[counts == 1]
    degree = np.bincount(rim.ravel(), minlength=len(garment.nodes))
    assert set(degree[degree > 0]) <= {2}, "a contour touches itself"
    loops, left = 0, {int(a): [] for a in np.unique(rim)}
    for a, b in rim.tolist():
        left[a].append(b)
        left[b].append(a)
    seen = set()
    for start in left:
        if start not in seen:
            loops += 1
            stack = [start]
            while stack:
                node = stack.pop()
                if node not in seen:
                    seen.add(node)
                    stack += left[node]
    return len(garment.nodes) - len(edges) + len(garment.faces), loops


def test_skirt_is_a_tube_with_a_tab(skirt_file):
    """Breaks where welding loses a seam end: two panels and a band on the front make one annulus."""
    garment = mesh_pattern(read_pattern(skirt_file), edge_length=0.03)
    assert _topology(garment) == (0, 2)


def test_tee_topology(tee_file):
    """Breaks where shoulders or sides are welded wrongly: neck, hem and two arm openings, half sleeves at them."""
    garment = mesh_pattern(read_pattern(tee_file), edge_length=0.03)
    assert _topology(garment) == (-2, 4)


@pytest.mark.parametrize("name", ["skirt_file", "tee_file"])
def test_seams_have_equal_counts_and_one_node(name, request):
    """Breaks where a gathered seam is sampled by its own length, or sides meet the wrong way round."""
    garment = mesh_pattern(read_pattern(request.getfixturevalue(name)), edge_length=0.025)
    for seam in garment.pattern.seams:
        a, b = garment.edge_uv[seam.a], garment.edge_uv[seam.b]
        assert len(a) == len(b) >= 3
        assert np.array_equal(garment.uv_node[a], garment.uv_node[b[::-1]])
    for ref, along in garment.edge_uv.items():
        points = edge_points(garment.pattern.panel(ref.panel), ref.edge, len(along) - 1)
        assert garment.uv[along] == pytest.approx(points, abs=1e-12)


def test_quality_count_and_area(tee_file):
    """Breaks where triangles are slivers, turned over, missing, or many more or fewer than asked."""
    garment = mesh_pattern(read_pattern(tee_file), vertex_count=1500)
    assert len(garment.nodes) == pytest.approx(1500, rel=0.08)
    angles = np.degrees(corner_angles(garment.uv, garment.uv_faces)).min(axis=1)
    assert angles.min() > 10.0
    assert np.quantile(angles, 0.01) > 25.0
    rest = garment.rest
    u, v = rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]
    area = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    assert area.min() > 0
    for index, panel in enumerate(garment.pattern.panels):
        # A mesh of chords misses at most a few per mille of a curved panel.
        assert area[garment.panel_of_face == index].sum() == pytest.approx(panel_area(panel), rel=5e-3)


def test_nodes_stand_at_the_mean_of_their_panels(skirt_file):
    """Breaks where placement is lost or a seam's node sticks to one side."""
    garment = mesh_pattern(read_pattern(skirt_file), edge_length=0.04)
    seam = garment.pattern.seams[0]
    on_seam = garment.nodes[garment.uv_node[garment.edge_uv[seam.a][1:-1]]]
    assert on_seam[:, 2] == pytest.approx(0.0, abs=1e-12)
    hem = garment.nodes[garment.uv_node[garment.edge_uv[EdgeRef("front", 0)][1:-1]]]
    assert hem[:, 2] == pytest.approx(0.2)


def test_faces_point_outwards(skirt_file):
    """Breaks where a clockwise panel's faces look inside."""
    garment = mesh_pattern(read_pattern(skirt_file), edge_length=0.04)
    a, b, c = (garment.nodes[garment.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)[:, 2]
    front, back = garment.panel_of_face == 0, garment.panel_of_face == 1
    assert (normal[front] > 0).mean() > 0.95 and (normal[back] < 0).mean() > 0.95


def test_meshing_is_deterministic(tee_file):
    """Breaks where anything depends on a set's order or a random number."""
    pattern = read_pattern(tee_file)
    one, two = mesh_pattern(pattern, 600), mesh_pattern(pattern, 600)
    assert np.array_equal(one.uv, two.uv) and np.array_equal(one.faces, two.faces)


def test_a_dart_closes():
    """Breaks where the two sides of a dart, sewn to each other, tear or fold the mesh."""
    points = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 0.3], [0.17, 0.3], [0.15, 0.15], [0.13, 0.3], [0.0, 0.3]])
    panel = Panel("p", points, (Edge(),) * 7)
    pattern = Pattern("dart", (panel,), (Seam(EdgeRef("p", 3), EdgeRef("p", 4)),))
    for size in (0.05, 0.03, 0.015):
        assert _topology(mesh_pattern(pattern, edge_length=size)) == (1, 1)


def test_two_sided_corner_is_no_fourfold_edge():
    """Breaks where both panels cut off the same sewn corner: their corner triangles then share an edge four times."""
    square = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]])
    panels = (Panel("a", square, (Edge(),) * 4), Panel("b", square, (Edge(),) * 4))
    # A cushion that is open on one side.
    seams = tuple(Seam(EdgeRef("a", i), EdgeRef("b", 3 - i)) for i in (0, 1, 2))
    for size in (0.2, 0.1, 0.05):
        assert _topology(mesh_pattern(Pattern("cushion", panels, seams), edge_length=size)) == (1, 1)


def test_moebius_band_is_refused():
    """Breaks where a one-sided surface is sewn: every normal would then be ambiguous."""
    strip = Panel("s", np.array([[0.0, 0.0], [0.6, 0.0], [0.6, 0.1], [0.0, 0.1]]), (Edge(),) * 4)
    pattern = Pattern("band", (strip,), (Seam(EdgeRef("s", 1), EdgeRef("s", 3), reversed=False),))
    with pytest.raises(BadInput) as caught:
        mesh_pattern(pattern, edge_length=0.03)
    assert caught.value.code == "pattern.not_orientable"


def test_crossing_outline_is_named():
    """Breaks where a panel that grading folded over gives a wrong mesh or an unclear error."""
    bow = Panel("bow", np.array([[0.0, 0.0], [0.3, 0.3], [0.3, 0.0], [0.0, 0.2]]), (Edge(),) * 4)
    with pytest.raises(BadInput) as caught:
        mesh_pattern(Pattern("p", (bow,), ()), edge_length=0.03)
    assert caught.value.code == "pattern.self_crossing" and "bow" in caught.value.message


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.floats(0.6, 1.4), min_size=4, max_size=9),
    st.lists(st.floats(-0.25, 0.25), min_size=9, max_size=9),
    st.sampled_from([0.03, 0.05, 0.09]),
)
def test_random_panels_mesh_well(radii, bends, size):
    """Breaks on some star-shaped panel: a lost boundary edge, a hole, a turned or needle triangle."""
    angle = 2 * np.pi * np.arange(len(radii)) / len(radii)
    points = 0.3 * np.array(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    kinds = [Edge("quadratic", np.array([[0.5, bend]])) for bend in bends[: len(radii)]]
    panel = Panel("p", points, tuple(kinds))
    try:
        garment = mesh_pattern(Pattern("p", (panel,), ()), edge_length=size)
    except BadInput as error:
        assert error.code in ("pattern.self_crossing", "pattern.degenerate")
        return
    assert _topology(garment) == (1, 1)
    assert np.degrees(corner_angles(garment.uv, garment.uv_faces)).min() > 0.0
    assert len(garment.nodes) == len(garment.uv)
