"""Texts on paper: within their piece, on one sheet, in words, and clear of the paper's edge; measured by pdfium."""

import pypdfium2
import pytest
import shapely
from garmentq.core.deliver.formats.letters import break_line, fit_size, measure_text
from garmentq.core.deliver.formats.papers import find_paper
from garmentq.core.deliver.formats.tiled_pdf import TILE_OVERLAP_MM, pieces_pdf, tile_pieces
from garmentq.core.garment.pieces.flatten import flatten_outline
from garmentq.core.garment.pieces.make import PieceSettings, Style, make_pieces
from garmentq.core.garment.pieces.trueing import describe_trueing
from garmentq.core.garment.templates import load_template
from garmentq_pieces import TEMPLATES, pieces_of
from shapely import Polygon

POINT = 72.0 / 25.4
SHIRT = "long_sleeve_tshirt+sleeve_head=set-in,cuff=shirt,collar=shirt,front=buttons,vent=sides"
HOODED = "tshirt+hood=three,hem_band=rib,cuff=rib"


def boxes(content, number):
    """Return the boxes of a page's texts [mm], and its width and height."""
    document = pypdfium2.PdfDocument(content)
    page = document[number]
    text = page.get_textpage()
    found = [tuple(side / POINT for side in text.get_rect(k)) for k in range(text.count_rects())]
    size = tuple(side / POINT for side in page.get_size())
    document.close()
    return found, size


@pytest.mark.parametrize("paper", ["a4", pytest.param("letter", marks=pytest.mark.nightly)])
@pytest.mark.parametrize("name", [*TEMPLATES, SHIRT, HOODED])
def test_no_text_is_cut_in_two(name, paper):
    """Broken where a text of a panel's piece crosses the strip where two sheets of paper meet, or leaves its piece."""
    pieces = pieces_of(name)
    sheet, tiling = tile_pieces(pieces, find_paper(paper))
    overlap, (wide, tall) = TILE_OVERLAP_MM / 1e3, (1e-3 * side for side in tiling.step)
    sheets = [
        shapely.box(
            tile.column * wide + (overlap if tile.column else -1.0),
            float(sheet.size[1]) - (tile.row + 1) * tall,
            (tile.column + 1) * wide,
            float(sheet.size[1]) - tile.row * tall - (overlap if tile.row else -1.0),
        )
        for tile in tiling.tiles
    ]
    for texts, piece, shift in zip(sheet.texts, pieces.pieces, sheet.shifts, strict=False):
        net = Polygon(flatten_outline(piece.net)[0] + shift).buffer(1e-6)
        for text in texts:
            x, y = text.centre
            box = shapely.box(x - text.width / 2, y, x + text.width / 2, y + text.size)
            assert box.within(net) and any(box.within(one) for one in sheets), (piece.name, text.text)


@pytest.mark.parametrize("title", ["tshirt", "W" * 60])
def test_pages_of_text_have_a_border(title):
    """Broken where a line of the cover, of a sheet's label or of the instructions comes closer than 10 mm to the edge
    of the paper, which printers leave out."""
    style = Style(title, "bust 92 waist 72 hip 100 height 170", "WWWWWWWWWW" * 6, details=(("scan", "W" * 100),))
    pieces = make_pieces(load_template(SHIRT), PieceSettings(), style)
    content = pieces_pdf(pieces, find_paper("a4"))
    count = len(tile_pieces(pieces, find_paper("a4"))[1].tiles)
    document = pypdfium2.PdfDocument(content)
    pages = [0, *range(count + 1, len(document))]
    document.close()
    for number in pages:
        found, (width, height) = boxes(content, number)
        assert found
        for left, low, right, high in found:
            assert left > 10.0 and low > 10.0 and right < width - 10.0 and high < height - 10.0


@pytest.mark.parametrize("is_bold", [False, True])
def test_widths_are_those_of_the_font(is_bold):
    """Broken where a measured line is not as wide as a PDF reader finds it, by more than a letter's bearings."""
    text, size = "COLLAR FALL, cut 2 (1 pair) @ 45.5 mm", 20.0
    from garmentq.core.deliver.formats.pdf_file import Page, pdf_bytes, show_text

    found, _ = boxes(pdf_bytes([Page(400.0, 100.0, show_text(10.0, 40.0, size, text, is_bold))], ""), 0)
    left, right = min(one[0] for one in found), max(one[2] for one in found)
    assert right - left == pytest.approx(measure_text(text, size, is_bold), abs=0.15 * size)


def test_lines_are_broken_at_blanks():
    """Broken where a part of a broken line is wider than its place, a word is lost, or a long name prints beyond it."""
    text = "inner collar seam 75.0 cm: COLLAR, COLLAR FALL; " + "X" * 60
    lines = break_line(text, 3.0, 60.0, "  ")
    assert all(measure_text(line, 3.0) <= 60.0 for line in lines)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    assert break_line("", 3.0, 60.0) == [""]
    assert measure_text(text, fit_size(text, 3.0, 60.0), False) == pytest.approx(60.0)
    assert fit_size("a", 3.0, 60.0) == 3.0


@pytest.mark.parametrize("name", ["tshirt", SHIRT, HOODED, "trousers"])
def test_paper_says_words(name):
    """Broken where a printed line has an underscore, or calls an armhole by another word."""
    pieces = make_pieces(load_template(name), PieceSettings(), Style("style"))
    sheet, _ = tile_pieces(pieces, find_paper("a4"))
    printed = [text.text for texts in sheet.texts for text in texts]
    document = pypdfium2.PdfDocument(pieces_pdf(pieces, find_paper("a4")))
    last = document[len(document) - 1].get_textpage().get_text_bounded()
    document.close()
    lines = [*printed, last, *describe_trueing(pieces.trued)]
    assert not any("_" in line or "scye" in line for line in lines)
