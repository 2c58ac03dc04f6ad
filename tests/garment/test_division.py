"""Edges cut into parts: the curve stays, the seams keep their edges."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_length, edge_points
from garmentq.core.garment.division import divide_edges
from garmentq.core.garment.seams import seam_lengths
from garmentq.core.garment.templates import load_template


@pytest.mark.parametrize("name", ["skirt", "tshirt", "trousers"])
def test_divided_edges_draw_the_same_curve_in_equal_parts(name: str) -> None:
    """Breaks if a cut moves the curve, or if the parts are equal in the parameter instead of in length."""
    whole = load_template(name)
    contours = {edge.contour for panel in whole.panels for edge in panel.edges if edge.contour}
    divided = divide_edges(whole, contours, 3)
    for panel, parts in zip(whole.panels, divided.panels, strict=True):
        number = 0
        for i, edge in enumerate(panel.edges):
            if edge.contour:
                lengths = [edge_length(parts, number + k) for k in range(3)]
                assert lengths == pytest.approx([edge_length(panel, i) / 3] * 3, rel=1e-4)
                drawn = np.concatenate([edge_points(parts, number + k, 8)[:-1] for k in range(3)])
                assert np.abs(drawn - edge_points(panel, i, 24)[:-1]).max() < 1e-4
            number += 3 if edge.contour else 1


def test_seams_keep_their_edges() -> None:
    """Breaks if seams point at the old edge numbers after a division."""
    whole = load_template("tshirt")
    divided = divide_edges(whole, {"hem", "neck"}, 2)
    assert np.allclose(seam_lengths(divided), seam_lengths(whole), atol=1e-9)


def test_notches_stay_where_they_are() -> None:
    """Breaks if a notch keeps its fraction of an edge that has become shorter."""
    from dataclasses import replace

    whole = load_template("skirt")
    edge = next(i for i, e in enumerate(whole.panels[0].edges) if e.contour == "hem")
    panel = replace(whole.panels[0], notches=((edge, 0.75),))
    divided = divide_edges(replace(whole, panels=(panel, *whole.panels[1:])), {"hem"}, 2)
    (number, at), *_ = divided.panels[0].notches
    found = edge_points(divided.panels[0], number, 200)[round(at * 200)]
    assert np.linalg.norm(found - edge_points(panel, edge, 400)[300]) < 1e-4
