"""Seams and edges of a pattern are named and measured as a tailor does."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import flat_contours
from garmentq.core.garment.pieces.pattern_lines import list_lines
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template


def test_the_lines_of_a_shirt() -> None:
    """Breaks where a seam or an edge is missing, is two lines, or left and right are one."""
    lines = {(line.name, line.side) for line in list_lines(load_template("tshirt"))}
    assert lines == {
        ("neckline", ""),
        ("hem", ""),
        *((name, side) for name in ("sleeve hem", "shoulder seam", "side seam", "armhole seam") for side in SIDES),
        *((name, side) for name in ("sleeve seam", "overarm seam") for side in SIDES),
    }


SIDES = ("left", "right")


@pytest.mark.parametrize("name", ["tshirt", "dress", "trousers", "skirt"])
def test_lengths_are_those_of_the_pattern(name: str) -> None:
    """Breaks where an edge is counted twice or not, or one side of a seam passes for both."""
    pattern = load_template(name)
    garment, flat = mesh_pattern(pattern, 600), flat_contours(pattern)
    names = {"neck": "neckline", "hem": "hem", "waist": "waist"}
    lines = {(line.name, line.side): line for line in list_lines(pattern)}
    for contour, word in names.items():
        if contour in flat:
            assert lines[word, ""].measure_length(pattern) == pytest.approx(flat[contour])
            assert lines[word, ""].is_open
    for line in lines.values():
        along = [garment.uv[garment.edge_uv[ref]] for ref in line.edges]
        length = sum(float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) for path in along)
        assert line.measure_length(pattern) == pytest.approx(length, rel=0.02)
        points, nodes = line.sample(garment), garment.nodes[line.find_nodes(garment)]
        assert all(np.linalg.norm(points - node, axis=1).min() < 1e-9 for node in nodes)
