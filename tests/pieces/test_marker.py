"""All copies of all pieces on cloth, read back as SVG and checked by shapely."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
from garmentq.core.deliver.formats.marker import marker_svg
from garmentq.core.garment.pieces import nesting
from garmentq.core.garment.pieces.layout import CLOTH_GAP, CLOTH_WIDTH, lay_on_cloth, list_copies
from garmentq.core.garment.pieces.make import PieceSettings, make_pieces
from garmentq.core.garment.pieces.nesting import nest_on_cloth
from garmentq.core.garment.templates import load_template
from shapely import Polygon


@pytest.fixture(scope="module")
def pieces():
    """Return the pieces of a T-shirt: front, back and a pair of sleeves."""
    return make_pieces(load_template("tshirt"))


def test_copies_are_mirrored_and_opened(pieces):
    """Broken where a pair has two left sleeves, or a folded piece is laid as a half."""
    names = [copy.name for copy in list_copies(pieces.pieces)]
    assert sorted(names) == ["BACK", "FRONT", "SLEEVE", "SLEEVE"]
    left, right = (Polygon(copy.outline) for copy in list_copies(pieces.pieces) if copy.name == "SLEEVE")
    mirrored = Polygon(np.asarray(right.exterior.coords) * [-1.0, 1.0])
    assert left.symmetric_difference(mirrored).area < 1e-9 < left.symmetric_difference(right).area
    folded = make_pieces(load_template("tshirt"), PieceSettings(fold=True))
    assert sum(piece.fold is not None for piece in folded.pieces) >= 2
    for copy, opened in zip(list_copies(pieces.pieces), list_copies(folded.pieces), strict=True):
        whole, both = Polygon(copy.outline), Polygon(opened.outline)
        shift = np.array(whole.centroid.coords[0]) - both.centroid.coords[0]
        assert both.is_valid and whole.symmetric_difference(Polygon(opened.outline + shift)).area < 1e-6


@pytest.mark.parametrize("lay", [lay_on_cloth, nest_on_cloth])
def test_copies_lie_apart_on_cloth_along_the_warp(lay, pieces, monkeypatch):
    """Broken where two copies overlap, one hangs over the selvedge, is turned off its grain or another size,
    or the extra is installed and not used."""
    monkeypatch.setattr(nesting, "NESTING_EXPLORATION_TIME", 1)
    found = lay(pieces.pieces)
    shapes = [Polygon(copy.outline) for copy in found.copies]
    assert min(a.distance(b) for n, a in enumerate(shapes) for b in shapes[:n]) >= CLOTH_GAP - 1e-6
    every = np.concatenate([copy.outline for copy in found.copies])
    assert every.min() >= -1e-9 and every[:, 0].max() <= CLOTH_WIDTH + 1e-9
    assert every[:, 1].max() == pytest.approx(found.length)
    assert found.used == pytest.approx(sum(shape.area for shape in shapes) / (found.length * CLOTH_WIDTH))
    if lay is nest_on_cloth and nesting.can_nest():
        assert found.length < 0.95 * lay_on_cloth(pieces.pieces).length
    for name in ("FRONT", "BACK", "SLEEVE"):
        own = [np.ptp(copy.outline, axis=0) for copy in found.copies if copy.name == name]
        true = next(np.ptp(piece.cut.points, axis=0) for piece in pieces.pieces if piece.name == name)
        assert np.allclose(own, true, atol=1e-6)
    root = ElementTree.fromstring(marker_svg(found, "a <b>"))
    assert len([one for one in root.iter() if one.get("class") == "cut"]) == 4
