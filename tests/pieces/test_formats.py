"""Files of pieces, read back by libraries that share no code with the writers."""

import functools
import io
import zipfile
from xml.etree import ElementTree

import ezdxf
import numpy as np
import pypdfium2
import pytest
import shapely
from garmentq.core.deliver.formats.dialects import DIALECTS_BY_NAME
from garmentq.core.deliver.formats.dxf import Block, dxf_text, rule_text, write_archive
from garmentq.core.deliver.formats.flat_dxf import FLAT_SHEET_WIDTH, flat_text
from garmentq.core.deliver.formats.layered_svg import pieces_svg
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.deliver.formats.papers import find_paper
from garmentq.core.deliver.formats.pdf_file import Page, pdf_bytes
from garmentq.core.deliver.formats.registry import DIALECTS
from garmentq.core.deliver.formats.sheet import arrange_pieces
from garmentq.core.deliver.formats.tiled_pdf import TILE_MARGIN_MM, draw_sheet, pieces_pdf, roll_page, tile_pieces
from garmentq.core.garment.curves import edge_length
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.pieces.allowance import read_allowances
from garmentq.core.garment.pieces.flatten import flatten_outline
from garmentq.core.garment.pieces.layout import lay_on_cloth
from garmentq.core.garment.pieces.make import PieceSettings, Style, make_pieces
from garmentq.core.garment.pieces.naming import say_name
from garmentq.core.garment.templates import list_templates, load_template
from garmentq.core.run.errors import GarmentqError
from garmentq_pieces import SLIT_CUTS, TEMPLATES, pieces_of
from pypdf import PdfReader
from shapely import LineString, Point, Polygon

BLOCK_DIALECTS = [name for name in DIALECTS if name != "flat"]
NAMES = [info.name for info in list_templates()]
POINT = 72.0 / 25.4


@functools.cache
def drawing_of(name, dialect, fold=False):
    """Read back a template's DXF; fold as asked."""
    pieces = pieces_of(name, fold=fold)
    text = dxf_text(pieces, [Block(p, p.name, "BASE") for p in pieces.cut_pieces], DIALECTS_BY_NAME[dialect])
    return text, ezdxf.read(io.StringIO(text, newline=None))


def to_metres(points, dialect):
    """Return points of a file in our axes [m]."""
    points = np.asarray(points, float)[..., :2] * (0.0254 if dialect.is_inch else 1e-3)
    return points @ np.array([[0.0, 1.0], [-1.0, 0.0]]) if dialect.grain_along_x else points


def outline_of(block, layer, dialect):
    line, *_ = [e for e in block if e.dxftype() == "POLYLINE" and e.dxf.layer == str(layer)]  # before marked lines
    return to_metres([v.dxf.location for v in line.vertices], dialect), line.is_closed


@pytest.mark.parametrize("dialect", BLOCK_DIALECTS)
@pytest.mark.parametrize(
    "name", ["tshirt", SLIT_CUTS[0], *(pytest.param(n, marks=pytest.mark.nightly) for n in NAMES[5:10])]
)
def test_dxf_says_what_the_pieces_are(name, dialect):
    """Broken where a reader finds other outlines, notches beside vertices or outwards, or a record too much."""
    text, drawing = drawing_of(name, dialect)
    rule, pieces = DIALECTS_BY_NAME[dialect], pieces_of(name).cut_pieces
    audit = drawing.audit()
    assert not audit.errors and not audit.fixes
    assert text.isascii() and max(map(len, text.splitlines())) <= 255
    assert {b.name for b in drawing.blocks if not b.name.startswith("*")} == {piece.name for piece in pieces}
    assert sorted(i.dxf.name for i in drawing.modelspace().query("INSERT")) == sorted(p.name for p in pieces)
    assert not any(entity.dxftype() == "INSERT" for block in drawing.blocks if block.name[0] != "*" for entity in block)
    step = 3e-6 if rule.is_inch else 1e-6
    for piece in pieces:
        block = drawing.blocks.get(piece.name)
        points, is_closed = outline_of(block, 1, rule)
        assert is_closed or np.array_equal(points[0], points[-1])
        found = Polygon(points)
        assert found.is_valid and found.area == pytest.approx(Polygon(piece.cut.points).area, rel=1e-4)
        sew, _ = outline_of(block, rule.sew_layer, rule)
        assert Polygon(sew).within(found)
        assert LineString([*sew, sew[0]]).length == pytest.approx(sum_edges(piece), abs=1e-4)
        marks = [e for e in block if e.dxf.layer == str(rule.notch_layer) and e.dxftype() in ("POINT", "LINE")]
        assert len(marks) == len(piece.notches)
        for mark, notch in zip(marks, piece.notches, strict=True):
            if rule.notch_is_line:
                place, end = to_metres([mark.dxf.start, mark.dxf.end], rule)
                inward = end - place
            else:
                place = to_metres([mark.dxf.location], rule)[0]
                angle = np.radians(mark.dxf.angle)
                inward = to_metres([[np.cos(angle), np.sin(angle)]], rule)[0]
                size = 0.0254 if rule.is_inch else 1e-3
                assert mark.dxf.location.z * size == pytest.approx(notch.depth, abs=2 * step)
            assert np.abs(points - place).max(axis=1).min() < step
            assert Point(place + 1e-3 * inward / np.linalg.norm(inward)).within(found)
        if rule.marks_points:
            corners = to_metres([p.dxf.location for p in block.query("POINT") if p.dxf.layer in ("2", "3")], rule)
            both = np.concatenate([points, sew])
            assert max(np.abs(both - corner).max(axis=1).min() for corner in corners) < step
        (grain,) = [e for e in block.query("LINE") if e.dxf.layer == "7"]
        along = np.array(grain.dxf.end - grain.dxf.start)[:2]
        assert piece.is_bias or abs(along[0 if not rule.grain_along_x else 1]) < 1e-9
    placed = []
    for insert in drawing.modelspace().query("INSERT"):
        points, _ = outline_of(drawing.blocks.get(insert.dxf.name), 1, rule)
        placed.append(Polygon(points + to_metres([insert.dxf.insert], rule)[0]))
    assert not any(one.intersects(other) for k, one in enumerate(placed) for other in placed[:k])
    texts = [to_metres([text.dxf.insert], rule)[0] for text in drawing.modelspace().query("TEXT")]
    assert texts and not any(one.contains(Point(text)) for one in placed for text in texts)


def sum_edges(piece):
    return sum(edge_length(piece.net, i) for i in range(len(piece.edges)))


def test_each_dialect_keeps_its_own_rule():
    """Broken where a dialect writes what its reader is known not to take."""
    texts = {name: drawing_of("tshirt", name)[0] for name in BLOCK_DIALECTS}
    assert "AC1006" in texts["clo"] and not any("$ACADVER" in texts[name] for name in BLOCK_DIALECTS if name != "clo")
    assert "UNITS: ENGLISH" in texts["gerber"] and "Piece Name: FRONT" in texts["gerber"]
    assert all("UNITS: METRIC" in texts[name] for name in BLOCK_DIALECTS if name != "gerber")
    assert "D6673-10" in texts["astm"] and "CURVE TOLERANCE" in texts["astm"]
    assert "SAMPLE SIZE: BASE" in texts["richpeace"] and "PIECE NAME" not in texts["richpeace"]
    layers = {
        name: {e.dxf.layer for block in drawing_of("tshirt", name)[1].blocks for e in block} for name in BLOCK_DIALECTS
    }
    assert "84" in layers["astm"] and "82" in layers["richpeace"] and "19" not in layers["optitex"]
    assert not layers["seamly"] & {"2", "3", "14"} and "8" in layers["seamly"]
    assert all("TABLES" not in text.splitlines() for text in texts.values())
    for name in ("gerber", "optitex", "richpeace"):
        points, is_closed = outline_of(drawing_of("tshirt", name)[1].blocks.get("FRONT"), 1, DIALECTS_BY_NAME[name])
        assert not is_closed and np.array_equal(points[0], points[-1])


def test_a_half_piece_has_its_mirror_line():
    """Broken where a reader cannot tell a half piece from a whole one."""
    _, drawing = drawing_of("tshirt", "aama", True)
    block = drawing.blocks.get("FRONT")
    (fold,) = [e for e in block.query("LINE") if e.dxf.layer == "6"]
    points, _ = outline_of(block, 1, DIALECTS_BY_NAME["aama"])
    edge = LineString(points[[0, -1]])
    assert edge.distance(Point(to_metres([fold.dxf.start], DIALECTS_BY_NAME["aama"])[0])) < 2e-6
    assert fold.dxf.start.x == fold.dxf.end.x


@pytest.mark.parametrize("name", TEMPLATES + SLIT_CUTS)
@pytest.mark.parametrize("fold", [pytest.param(False, marks=pytest.mark.nightly), True])
def test_every_template_is_written_in_every_format(name, fold):
    """Broken where a template has no PDF, SVG or DXF, or the same pieces give other bytes."""
    pieces = pieces_of(name, fold=fold)
    drawing_of(name, "aama", fold)
    first = pieces_pdf(pieces, find_paper("a4"))
    assert len(PdfReader(io.BytesIO(first)).pages) > 3
    assert pieces_svg(pieces).count("inkscape:groupmode") == 7
    if name == "tshirt":
        again = make_pieces(
            load_template(name), PieceSettings(read_allowances(""), fold), Style("tshirt", pieces.size, pieces.fabric)
        )
        assert pieces_pdf(again, find_paper("a4")) == first
        assert pieces_svg(again) == pieces_svg(pieces)


def render(content, page=0, dpi=600, crop=None):
    """Return a page as grey values, from its upper left corner."""
    document = pypdfium2.PdfDocument(content)
    image = document[page].render(scale=dpi / 72.0, crop=crop or (0, 0, 0, 0), grayscale=True).to_numpy()
    document.close()
    return image[..., 0] if image.ndim == 3 else image


def test_the_test_squares_measure_what_they_say():
    """Broken where a printer would shrink every piece: 50.0 and 50.8 mm to 0.1 mm at 600 dpi, no scaling asked for."""
    content = pieces_pdf(pieces_of("tshirt"), find_paper("a4"))
    reader = PdfReader(io.BytesIO(content))
    assert reader.trailer["/Root"]["/ViewerPreferences"]["/PrintScaling"] == "/None"
    assert [float(x) for x in reader.pages[0].mediabox[2:]] == pytest.approx([595.276, 841.890], abs=1e-3)
    image = render(content)
    pixel = 25.4 / 600
    across = image[int(65 / pixel) : int(100 / pixel)]  # between the squares' upper and lower sides
    sides = np.flatnonzero((across < 128).all(axis=0))
    groups = np.split(sides, np.flatnonzero(np.diff(sides) > 3) + 1)
    middles = [group.mean() * pixel for group in groups]
    assert len(middles) == 4
    assert middles[1] - middles[0] == pytest.approx(50.0, abs=0.1)
    assert middles[3] - middles[2] == pytest.approx(50.8, abs=0.1)


@pytest.mark.parametrize("name", ["a4", pytest.param("letter", marks=pytest.mark.nightly)])
def test_pasted_sheets_are_the_whole_sheet(name):
    """Broken where a sheet is cut at another place than where it is pasted, or one with a line on it is left out."""
    paper, dpi = find_paper(name), 50.8  # 2 pixels a millimetre
    sheet, tiling = tile_pieces(pieces_of("tshirt"), paper)
    size = np.ceil(sheet.size * 1e3).astype(int)
    plain = pdf_bytes([Page(float(size[0]), float(size[1]), "/Drawing Do\n")], "", draw_sheet(sheet))
    whole = render(plain, dpi=dpi) < 128
    content = pieces_pdf(pieces_of("tshirt"), paper)
    pasted = np.zeros_like(whole)
    top = size[1] - float(sheet.size[1]) * 1e3
    for n, one in enumerate(tiling.tiles, 1):
        image = render(content, n, dpi) < 192  # a thin line between two rows of pixels is grey in both
        inner = image[
            int(2 * TILE_MARGIN_MM) + 3 : -int(2 * TILE_MARGIN_MM) - 3,
            int(2 * TILE_MARGIN_MM) + 3 : -int(2 * TILE_MARGIN_MM) - 3,
        ]
        y = round(2 * (top + one.row * tiling.step[1])) + 3
        x = round(2 * one.column * tiling.step[0]) + 3
        inner = inner[: pasted.shape[0] - y, : pasted.shape[1] - x]
        pasted[y : y + inner.shape[0], x : x + inner.shape[1]] |= inner
    near = np.zeros_like(whole)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            near |= np.roll(pasted, (dy, dx), (0, 1))
    assert (whole & ~near).sum() / whole.sum() < 2e-3


def test_path_coordinates_are_the_cut_lines():
    """Broken where a piece is drawn elsewhere or at another scale: read back by pypdf to 0.01 mm."""
    pieces = pieces_of("tshirt")
    content = pieces_pdf(pieces, find_paper("roll"))
    page = PdfReader(io.BytesIO(content)).pages[0]
    text = page["/Resources"]["/XObject"]["/Drawing"].get_object().get_data().decode()
    sheet = arrange_pieces(pieces, (find_paper("roll").width - 2 * TILE_MARGIN_MM) / 1e3)
    paths = [
        line.split("d ", 1)[1] for line in text.splitlines() if line.startswith("0.35 w [] 0 d") and line.endswith(" s")
    ]
    assert len(paths) == len(pieces.cut_pieces)
    for path, outline in zip(paths, sheet.outlines, strict=True):
        numbers = np.array([float(word) for word in path.split() if word not in "mls"]).reshape(-1, 2)
        assert np.abs(numbers - 1e3 * outline).max() < 0.01
    assert np.allclose([float(page.mediabox[2]) / POINT], [914.0])


@pytest.mark.parametrize("name", TEMPLATES)
def test_texts_lie_within_their_pieces(name):
    """Broken where a label sticks out of its piece, is under 5 mm, or covers a notch."""
    sheet = arrange_pieces(pieces_of(name), 1.4)
    for texts, piece, shift in zip(sheet.texts, sheet.pieces.cut_pieces, sheet.shifts, strict=True):
        assert texts, piece.name
        net = Polygon(flatten_outline(piece.net)[0] + shift)
        for text in texts:
            x, y = text.centre
            box = shapely.box(x - text.width / 2, y, x + text.width / 2, y + text.size)
            assert text.size >= 0.005 and box.within(net)
            assert not any(box.intersects(Point(notch.point + shift)) for notch in piece.notches)


@pytest.mark.parametrize("name", ["tshirt", "jumpsuit", SLIT_CUTS[0]])
def test_a_flat_drawing_has_a_layer_for_each_tool(name):
    """Broken where a laser would burn a sew line, pieces lie upon each other, or a drawing program finds blocks, other
    areas, notches elsewhere, or grainlines that are not upright."""
    pieces = pieces_of(name)
    drawing = ezdxf.read(io.StringIO(flat_text([("", pieces)]), newline=None))
    audit = drawing.audit()
    assert not audit.errors and not audit.fixes
    assert {layer.dxf.name: layer.dxf.color for layer in drawing.layers} | {"0": 7} == {
        "0": 7, "CUT": 1, "SEW": 5, "MARK": 3, "TEXT": 7,
    } | {layer.dxf.name: layer.dxf.color for layer in drawing.layers if layer.dxf.name == "Defpoints"}  # fmt: skip
    space = drawing.modelspace()
    assert {entity.dxftype() for entity in space} == {"POLYLINE", "TEXT"}
    lines = {
        layer: [1e-3 * np.array([v.dxf.location for v in line.vertices])[:, :2] for line in space.query("POLYLINE")
                if line.dxf.layer == layer]
        for layer in ("CUT", "SEW", "MARK")
    }  # fmt: skip
    cut = [Polygon(points) for points in lines["CUT"]]
    assert [one.area for one in cut] == pytest.approx([Polygon(p.cut.points).area for p in pieces.cut_pieces], rel=1e-4)
    assert not any(one.intersects(other) for k, one in enumerate(cut) for other in cut[:k])
    shifts = arrange_pieces(pieces, FLAT_SHEET_WIDTH).shifts
    starts = np.array([line[0] for line in lines["MARK"]])
    for piece, shift in zip(pieces.cut_pieces, shifts, strict=True):
        for notch in piece.notches:
            assert np.linalg.norm(starts - notch.point - shift, axis=1).min() < 1e-6
        grain = piece.grain + shift
        (drawn,) = [line for line in lines["MARK"] if len(line) == 2 and np.abs(line - grain).max() < 1e-6]
        assert piece.is_bias or drawn[0, 0] == pytest.approx(drawn[1, 0], abs=1e-6)
    texts = space.query("TEXT")
    assert {say_name(piece.name) for piece in pieces.cut_pieces} <= {text.dxf.text for text in texts}
    assert all(any(one.contains(Point(np.array(text.dxf.insert)[:2] * 1e-3)) for one in cut) for text in texts)


def test_archive_holds_both_files_and_a_note(tmp_path):
    """Broken where DXF and rule table part ways, or an archive differs from one second to the next."""
    dialect = DIALECTS_BY_NAME["clo"]
    files = {"pieces_clo.dxf": "0\r\nEOF\r\n", "pieces_clo.rul": rule_text(dialect, ("A", "B"), [np.eye(2)])}
    first = write_archive(files, dialect, tmp_path, "pieces_clo.zip")[-1].read_bytes()
    assert write_archive(files, dialect, tmp_path, "pieces_clo.zip")[-1].read_bytes() == first
    with zipfile.ZipFile(io.BytesIO(first)) as archive:
        assert set(archive.namelist()) == {*files, "README.txt"} and archive.testzip() is None
        assert "millimetres" in archive.read("README.txt").decode()


def test_hostile_names_reach_no_file():
    """Broken where a name of a user's own becomes a record of DXF, a mark of SVG or an operator of PDF."""
    evil = "x\n  0\nEOF\n) Tj <script>&\\(\x00\u202e" + "y" * 500
    corners = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 0.3], [0.0, 0.3]])
    panel = Panel(evil, corners, (Edge(label=evil, contour=evil),) * 4, label=evil)
    pieces = make_pieces(Pattern(evil, (panel,), ()), None, Style(evil, evil, evil))
    texts = [
        dxf_text(pieces, [Block(p, p.name, "BASE") for p in pieces.cut_pieces], DIALECTS_BY_NAME[dialect])
        for dialect in BLOCK_DIALECTS
    ]
    for text in (*texts, flat_text([("", pieces)])):
        assert text.count("EOF\r\n") == 1 and text.isascii() and max(map(len, text.splitlines())) <= 255
        assert not ezdxf.read(io.StringIO(text, newline=None)).audit().errors
    assert len(PdfReader(io.BytesIO(pieces_pdf(pieces, find_paper("a4")))).pages) == 6
    ElementTree.fromstring(pieces_svg(pieces))


@pytest.mark.parametrize(
    "wrong",
    [
        {"format": "doc"}, {"dialect": "x"}, {"paper": "a9"}, {"paper": "roll:1"}, {"paper": "roll:nan"},
        {"allowance": "hem=-1"}, {"step": 0.0}, {"step": float("nan")}, {"first": 1}, {"last": 99},
    ],
)  # fmt: skip
def test_wrong_options_end_in_a_code(wrong):
    """Broken where what there is not is taken for something."""
    with pytest.raises(GarmentqError) as caught:
        ExportOptions(**{"format": "pdf", **wrong})
    assert caught.value.code in ("export.unknown", "export.paper", "export.sizes", "pieces.allowance")


def test_cloth_holds_all_copies():
    """Broken where a second sleeve is forgotten, or boxes of pieces overlap."""
    whole, folded = (lay_on_cloth(pieces_of("tshirt", fold=fold).pieces) for fold in (False, True))
    area = sum(p.quantity * Polygon(p.cut.points).area for p in pieces_of("tshirt").pieces)
    assert whole.used * whole.length * whole.width == pytest.approx(area)
    assert folded.length == pytest.approx(whole.length) and 0.4 < whole.used < 1.0
    assert np.isinf(lay_on_cloth(pieces_of("tshirt").pieces, 0.3).length)


def test_a_long_roll_has_larger_units():
    """Broken where a page over 200 in is cut off: its own units grow instead."""
    page = roll_page(arrange_pieces(pieces_of("dress"), 0.9), 914.0)
    long = Page(914.0, 6000.0, page.content)
    found = PdfReader(io.BytesIO(pdf_bytes([long], "t"))).pages[0]
    assert float(found.mediabox[3]) <= 14400
    assert float(found.mediabox[3]) * float(found["/UserUnit"]) == pytest.approx(6000.0 * POINT, rel=1e-5)


@pytest.mark.parametrize("name", TEMPLATES + SLIT_CUTS)
def test_notches_and_grain_are_read_back(name):
    """Broken where SVG or PDF has another outline, a notch elsewhere, or a grainline that is not upright, for any
    piece, those that finish openings too."""
    pieces = pieces_of(name)
    sheet = arrange_pieces(pieces, 1.4)
    height = 1e3 * float(sheet.size[1])
    space = "{http://www.w3.org/2000/svg}"
    groups = {group.get("id"): group for group in ElementTree.fromstring(pieces_svg(pieces)).iter(f"{space}g")}

    def lines_of(layer, piece):
        group = groups.get(f"{layer}.{piece.name}")
        found = [] if group is None else [path.get("d") for path in group.findall(f"{space}path")]
        words = [[float(word) for word in d.split() if word not in "MLZ"] for d in found]
        return [(np.array(line).reshape(-1, 2) * [1.0, -1.0] + [0.0, height]) / 1e3 for line in words]

    drawn = PdfReader(io.BytesIO(pieces_pdf(pieces, find_paper("a4"))))
    stream = drawn.pages[0]["/Resources"]["/XObject"]["/Drawing"].get_object().get_data().decode()
    tiled, _ = tile_pieces(pieces, find_paper("a4"))
    strokes = [
        1e-3 * np.array([float(word) for word in line.split("d ", 1)[1].split() if word not in "mlsS"]).reshape(-1, 2)
        for line in stream.splitlines()
        if line.endswith((" s", " S"))
    ]
    starts = np.array([stroke[0] for stroke in strokes])
    for n, piece in enumerate(pieces.cut_pieces):
        (outline,) = lines_of("cut", piece)
        assert Polygon(outline).area == pytest.approx(Polygon(piece.cut.points).area, rel=1e-4)
        notches = np.array([line[0] for line in lines_of("notch", piece)]).reshape(-1, 2) - sheet.shifts[n]
        assert notches == pytest.approx(np.array([notch.point for notch in piece.notches]).reshape(-1, 2), abs=1e-6)
        if piece.fold is None:
            line = lines_of("grain", piece)[0]
            assert piece.is_bias or abs(line[0, 0] - line[-1, 0]) < 1e-6
            assert any(np.abs(stroke[[0, -1]] - piece.grain - tiled.shifts[n]).max() < 2e-6 for stroke in strokes)
        for notch in piece.notches:
            assert np.linalg.norm(starts - notch.point - tiled.shifts[n], axis=1).min() < 2e-6
