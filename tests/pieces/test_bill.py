"""Bills of material against the pieces and seams they are for."""

import pytest
from garmentq.core.deliver.formats.cover_page import list_bill
from garmentq.core.garment.pieces.bill import ELASTIC_OVERLAP, list_materials
from garmentq.core.garment.pieces.layout import lay_on_cloth
from garmentq.core.garment.pieces.make import Style, make_pieces
from garmentq.core.garment.templates import load_template


def bill_of(name, is_stretchy=False):
    made = make_pieces(load_template(name), None, Style(is_stretchy=is_stretchy))
    return made, {line.item: line.amount for line in list_materials(made)}


def test_cloth_is_what_the_layout_needs():
    """Broken where facings are not bought, a width that is too narrow is listed, or wider cloth needs more of it."""
    made, bill = bill_of("tank")
    assert bill["cloth 140 cm wide"] == lay_on_cloth(made.cut_pieces, 1.4).length
    lengths = [bill[f"cloth {width} cm wide"] for width in (90, 115, 140, 150)]
    assert lengths == sorted(lengths, reverse=True)
    assert bill["interfacing 90 cm wide"] < 0.5
    _, wide = bill_of("skirt+skirt=full-circle")
    assert not any(item.startswith("cloth 90") for item in wide)


def test_a_knit_needs_rib_and_other_thread():
    """Broken where a T-shirt's neckband is cut of nothing, or its seams are counted as lockstitched."""
    _, bill = bill_of("tshirt", is_stretchy=True)
    _, woven = bill_of("tshirt")
    assert 0.0 < bill["rib 100 cm wide"] < 0.2 and "rib 100 cm wide" not in woven
    assert bill["thread, lockstitch"] < woven["thread, lockstitch"]


@pytest.mark.parametrize(
    ("name", "item", "low", "high"),
    [
        ("tshirt+front=zip", "front zip", 0.4, 0.8),
        ("tshirt+front=buttons", "front buttons", 6, 9),
        ("long_sleeve_tshirt+cuff=shirt", "cuff buttons", 4, 4),
        ("tshirt+hood=two", "cord for the hood", 1.0, 1.6),
        ("trousers", "elastic for the waist", 0.72, 0.85),
    ],
)
def test_closures_are_as_long_as_their_openings(name, item, low, high):
    """Broken where a zip, a cord or the elastic is left out, counted twice, or buttons are too few."""
    made, bill = bill_of(name)
    assert low <= bill[item] <= high
    if item == "front zip":
        assert bill[item] == pytest.approx(sum(seam.lengths[0] for seam in made.seams if seam.name == "front zip"))


def test_elastic_is_as_long_as_its_band():
    """Broken where a gathered waist gets elastic as long as the skirt that it gathers."""
    made, bill = bill_of("skirt+waistband=elastic")
    (seam,) = {seam.name for seam in made.seams if seam.name == "waistband seam"}
    band = sum(min(one.lengths) for one in made.seams if one.name == seam)
    assert bill["elastic for the waist"] - ELASTIC_OVERLAP == pytest.approx(band, rel=0.02)
    assert any(line.startswith("elastic for the waist: 0.7") for line in list_bill(made))
