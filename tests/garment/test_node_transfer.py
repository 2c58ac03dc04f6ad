"""The mesh of an edited pattern begins where the present garment has the same cloth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.editing.cutting import cut_panel
from garmentq.core.garment.editing.edge_division import split_edges
from garmentq.core.garment.editing.joining import join_panels
from garmentq.core.garment.editing.move_points import move_points
from garmentq.core.garment.node_transfer import transfer_nodes
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.geometry.surface import TriangleSurface

NEAR = 0.004
"""Distance [m] that is none: so far a chord of 25 mm, the edge of the present mesh, leaves a fold of 20 mm radius."""


@pytest.fixture(scope="module")
def worn():
    """Return a T-shirt that hangs."""
    return load_draped_template("tshirt")


def strain(garment) -> np.ndarray:
    """Return how much longer each edge is than it is flat, as a share of that, shape [3 face_count]."""
    lengths = [
        np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).ravel()
        for corners in (garment.nodes[garment.faces], garment.rest)
    ]
    return lengths[0] / lengths[1] - 1.0


def test_moved_points_keep_mesh_and_nodes(worn):
    """Broken where an edit that only moves points makes another mesh, or moves cloth before the drape."""
    wider = move_points(worn.pattern, [("front", 0)], np.array([0.01, 0.0]))
    laid = transfer_nodes(worn, wider)
    assert np.array_equal(laid.nodes, worn.nodes) and np.array_equal(laid.faces, worn.faces)
    assert laid.pattern is wider and 1e-3 < np.abs(laid.uv - worn.uv).max() < 0.011
    far = worn.pattern.with_points({"front": worn.pattern.panel("front").points * [1.0, 3.0]})
    assert transfer_nodes(worn, far) is None, "a metre beyond the cloth nobody knows where it would hang"


@pytest.mark.parametrize("edit", ["split", "cut", "cut_and_joined"])
def test_changed_panels_hang_where_the_cloth_was(worn, edit):
    """Broken where a panel that was cut, joined or given a point begins anywhere but on the present cloth."""
    pattern = split_edges(worn.pattern, "front", 0, 0.4)
    present = worn
    if edit != "split":
        pattern = cut_panel(pattern, "front", np.array([[-0.4, -0.4], [0.4, -0.35]]))
    if edit == "cut_and_joined":
        present = transfer_nodes(worn, pattern)
        pattern = join_panels(pattern, len(pattern.seams) - 1)
    laid = transfer_nodes(present, pattern)
    assert [panel.name for panel in laid.pattern.panels] == [panel.name for panel in pattern.panels]
    assert TriangleSurface(worn.nodes, worn.faces).distance(laid.nodes).max() < NEAR
    assert np.quantile(np.abs(strain(laid)), 0.95) < np.quantile(np.abs(strain(worn)), 0.95) + 0.1


def test_cloth_that_grows_goes_on(worn):
    """Broken where new cloth beyond the outline is heaped up on it, or flies off."""
    pattern = split_edges(worn.pattern, "front", 8, 0.5)
    longer = move_points(pattern, [("front", 0), ("front", 8), ("front", 9)], np.array([0.0, -0.02]))
    laid = transfer_nodes(worn, longer)
    assert 0.01 < worn.nodes[:, 1].min() - laid.nodes[:, 1].min() < 0.04
    assert np.abs(strain(laid)).max() < 1.0


def test_a_panel_from_nowhere_has_no_place(worn):
    """Broken where a panel that nothing is known of is laid on cloth that it never was."""
    panel = replace(worn.pattern.panels[0], name="hood", translation=np.array([0.0, 3.0, 0.0]))
    assert transfer_nodes(worn, replace(worn.pattern, panels=(*worn.pattern.panels, panel))) is None
    divided = split_edges(worn.pattern, "front", 0, 0.4)
    away = divided.with_points({"front": divided.panel("front").points + 5.0})
    assert transfer_nodes(worn, away) is None
