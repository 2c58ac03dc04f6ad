"""Names of edges and control points."""

from __future__ import annotations

from garmentq.core.garment.pieces.edge_names import name_edges
from garmentq.core.garment.templates import load_template


def test_a_shirt_has_the_names_of_a_pattern_maker():
    """Broken where a line or point of a T-shirt has no name, or left and right are exchanged."""
    shirt = load_template("tshirt")
    names = name_edges(shirt)
    front = names["front"]
    assert set(front.lines) == {"hem", "side seam", "armhole", "shoulder seam", "neckline"}
    assert {"CF of the neckline", "left high point of the shoulder (HPS)", "right underarm point"} <= set(front.points)
    assert "CB of the neckline" in names["back"].points
    assert set(names["sleeve_front_left"].lines) == {"sleeve cap", "sleeve seam", "overarm seam", "sleeve hem"}
    x = shirt.panel("front").points[:, 0] + shirt.panel("front").translation[0]
    assert x[front.points.index("left shoulder point")] > x[front.points.index("right shoulder point")]


def test_trousers_have_their_own_names():
    """Broken where a leg's point is called centre front or back off the wearer's middle."""
    names = name_edges(load_template("trousers"))
    assert {"waist", "leg hem", "inseam", "side seam", "front crotch seam"} <= set(names["front_left"].lines)
    assert [name for name in names["front_left"].points if "CF" in name] == ["CF of the waist"]
    assert [name for name in names["back_left"].points if "CB" in name] == ["CB of the waist"]
