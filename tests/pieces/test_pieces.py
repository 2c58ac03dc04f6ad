"""Production pieces against the pattern they come from, and their cut lines against another library's offsets."""

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_length, edge_points
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.pieces.allowance import read_allowances
from garmentq.core.garment.pieces.errors import AllowanceBad
from garmentq.core.garment.pieces.flatten import flatten_edge, flatten_outline
from garmentq.core.garment.pieces.make import PieceSettings, make_pieces
from garmentq.core.garment.pieces.piece import TURNED_UP_EDGE_USES, EdgeUse
from garmentq.core.garment.pieces.trueing import true_pattern
from garmentq.core.garment.templates import load_template
from garmentq_pieces import SLIT_CUTS, TEMPLATES, pieces_of
from shapely import LineString, Point, Polygon


def settings(text="", fold=False):
    return PieceSettings(read_allowances(text), fold)


@pytest.mark.parametrize("name", TEMPLATES + SLIT_CUTS)
def test_unfolded_pieces_are_the_panels(name):
    """Broken where joining, pairing or folding moves an edge: each panel comes back out of the pieces to 0.05 mm."""
    pattern = true_pattern(load_template(name)).pattern
    for fold in (False, True):
        pieces = pieces_of(name, fold=fold).pieces
        places = {place.panel: place for piece in pieces for place in piece.places}
        assert sorted(places) == sorted(panel.name for panel in pattern.panels)
        seen = set()
        for piece in pieces:
            for i, edge in enumerate(piece.edges):
                drawn = edge_points(piece.net, i, 2)
                if edge.source is None:
                    assert fold and i == piece.fold
                    continue
                copies = [(edge.source, edge.part, drawn)]
                if edge.mirror is not None:
                    other = drawn if piece.pair else drawn * [-1, 1] + [2 * piece.net.points[piece.fold, 0], 0]
                    copies.append((edge.mirror, (1.0 - edge.part[0], 1.0 - edge.part[1]), other))
                for ref, (start, end), found in copies:
                    whole = edge_points(pattern.panel(ref.panel), ref.edge, 64)
                    expected = whole[[round(64 * at) for at in (start, (start + end) / 2, end)]]
                    moved = expected @ places[ref.panel].rotation.T + places[ref.panel].translation
                    assert np.abs(moved - found).max() < 5e-5
                    seen.add(ref)
        edges = {EdgeRef(panel.name, i) for panel in pattern.panels for i in range(len(panel.edges))}
        assert edges - seen == joined(pattern, pieces)


def joined(pattern, pieces):
    """Return the edges that lie within a joined piece."""
    home = {place.panel: piece.name for piece in pieces for place in piece.places}
    known = {edge.source for piece in pieces for edge in piece.edges} | {
        edge.mirror for piece in pieces for edge in piece.edges
    }
    return {
        ref
        for seam in pattern.seams
        for ref in (seam.a, seam.b)
        if ref not in known and home[seam.a.panel] == home[seam.b.panel]
    }


def test_half_sleeves_are_one_piece_cut_as_a_pair():
    """Broken where a T-shirt is cut in six pieces instead of three, or a sleeve is joined below the arm."""
    pieces = {piece.name: piece for piece in pieces_of("tshirt").pieces}
    assert list(pieces) == ["FRONT", "BACK", "SLEEVE"]
    assert [(piece.quantity, piece.pair) for piece in pieces.values()] == [(1, False), (1, False), (2, True)]
    sleeve = pieces["SLEEVE"]
    assert len(sleeve.places) == 4 and sum(np.linalg.det(place.rotation) < 0 for place in sleeve.places) == 2
    labels = [edge.label.split(".")[0] for edge in sleeve.net.edges]
    assert "oversleeve" not in labels and labels.count("undersleeve") == 2


@pytest.mark.parametrize("name", TEMPLATES + SLIT_CUTS)
def test_both_sides_of_each_seam_are_equally_long(name):
    """Broken where a seam of the pieces walks off by more than 0.5 mm, is lost, or counts a folded half once."""
    pattern = true_pattern(load_template(name)).pattern
    for fold in (False, True):
        made = pieces_of(name, fold=fold)
        assert all(abs(seam.lengths[0] - seam.lengths[1]) < 5e-4 for seam in made.seams if not seam.gathered)
        within = len(joined(pattern, made.pieces)) / 2
        assert len(made.seams) == len(pattern.seams) - within
        total = sum(edge_length(pattern.panel(s.a.panel), s.a.edge) for s in pattern.seams)
        lost = sum(edge_length(pattern.panel(ref.panel), ref.edge) for ref in joined(pattern, made.pieces)) / 2
        assert sum(seam.lengths[0] for seam in made.seams) == pytest.approx(total - lost, abs=1e-5)


@pytest.mark.parametrize("name", TEMPLATES)
def test_cut_lines_are_what_shapely_offsets(name):
    """Broken where an even allowance is not 10 mm everywhere: shapely's mitred buffer differs by under 0.2 mm2."""
    even = ",".join(f"{use}=10" for use in EdgeUse if use not in ("dart", "fold"))
    for piece in pieces_of(name, even).pieces:
        if any(edge.use in TURNED_UP_EDGE_USES for edge in piece.edges):
            continue  # mirrored at the fold; below
        net, cut = Polygon(flatten_outline(piece.net)[0]), Polygon(piece.cut.points)
        assert cut.is_valid and net.within(cut)
        assert cut.symmetric_difference(net.buffer(0.01, join_style="mitre", mitre_limit=3.0)).area < 2e-7


@pytest.mark.parametrize("name", TEMPLATES)
def test_each_edge_has_its_allowance(name):
    """Broken where a side of the cut line is not at its edge's allowance (0.01 mm), or the outline crosses itself."""
    for piece in pieces_of(name).pieces:
        net, cut = Polygon(flatten_outline(piece.net)[0]), Polygon(piece.cut.points)
        assert cut.is_valid and cut.exterior.is_ccw and net.within(cut.buffer(1e-9))
        assert len({edge for edge in piece.cut.edge if edge >= 0}) == len(piece.edges)
        ends = np.roll(piece.cut.points, -1, axis=0)
        for number in range(len(piece.edges)):
            line = LineString(flatten_edge(piece.net, number))
            for k in np.flatnonzero(piece.cut.edge == number):
                at = Point((piece.cut.points[k] + ends[k]) / 2)
                if 0.0 < line.project(at) < line.length:  # not where a mitre runs on beyond the edge
                    assert line.distance(at) == pytest.approx(piece.edges[number].width, abs=1e-5)


@pytest.mark.parametrize("name", TEMPLATES)
def test_hems_turned_up_lie_on_cloth(name):
    """Broken where a hem, mirrored at its fold, sticks out of the piece: its sides must mirror the side seams'."""
    for piece in pieces_of(name).pieces:
        cut = Polygon(piece.cut.points)
        for i, edge in enumerate(piece.edges):
            if edge.use not in TURNED_UP_EDGE_USES or piece.net.edges[i].kind != "line":
                continue
            neighbours = [piece.edges[(i + k) % len(piece.edges)].use for k in (-1, 1)]
            if any(use in TURNED_UP_EDGE_USES for use in neighbours):
                continue
            a, b = piece.net.points[i], piece.net.points[(i + 1) % len(piece.net.points)]
            along = (b - a) / np.linalg.norm(b - a)
            out = np.array([along[1], -along[0]])
            corners = [a - along + 0 * out, b + along, b + along + out, a - along + out]
            hem = cut.intersection(Polygon(corners))
            assert hem.area > 0.9 * edge.width * np.linalg.norm(b - a)
            turned = Polygon([p - 2 * ((p - a) @ out) * out for p in np.array(hem.exterior.coords)])
            assert turned.difference(cut).area < 1e-8  # 0.01 mm2


@pytest.mark.parametrize("name", TEMPLATES)
def test_notches_stand_on_vertices_and_point_inward(name):
    """Broken where a plotter finds a notch beside the outline, outside it, or deeper than the allowance."""
    for fold in (False, True):
        for piece in pieces_of(name, fold=fold).pieces:
            cut = Polygon(piece.cut.points)
            assert piece.notches
            for notch in piece.notches:
                assert np.abs(piece.cut.points - notch.point).sum(axis=1).min() == 0.0
                assert Point(notch.point + notch.depth * notch.inward).within(cut)
                assert np.linalg.norm(notch.inward) == pytest.approx(1.0)
                assert np.linalg.norm(notch.sew - notch.point) > notch.depth or notch.purpose == "hem"


@pytest.mark.parametrize("name", TEMPLATES)
def test_both_sides_of_a_seam_are_notched_alike(name):
    """Broken where a notch has no counterpart: the same distance from the seam's start on both sides."""
    made = pieces_of(name)

    def distances(side):
        found, start = [], 0.0
        for part in side:
            piece = made.pieces[part.piece]
            length = edge_length(piece.net, part.edge)
            ats = [n.at for n in piece.notches if n.edge == part.edge and n.purpose == "match"]
            found += [start + length * (1.0 - at if part.mirrored else at) for at in ats]
            start += length
        return np.array(sorted(found))

    for seam in made.seams:
        if not seam.gathered:
            first, second = distances(seam.sides[0]), distances(seam.sides[1])
            assert len(first) == len(second)
            assert np.abs(first - (seam.lengths[1] - second)[::-1]).max(initial=0.0) < 5e-4


def test_what_is_cut_on_the_fold_is_half():
    """Broken where the half is not half: its area twice is the whole's, and the fold runs along the warp."""
    whole = pieces_of("tshirt").pieces[0]
    half = pieces_of("tshirt", fold=True).pieces[0]
    assert whole.fold is None and half.fold is not None
    assert 2 * Polygon(half.cut.points).area == pytest.approx(Polygon(whole.cut.points).area, rel=1e-9)
    fold = half.net.points[[half.fold, (half.fold + 1) % len(half.net.points)]]
    assert np.ptp(fold[:, 0]) == 0.0 and half.edges[half.fold].use == EdgeUse.FOLD


def test_no_allowance_cuts_the_net_outline():
    """Broken where `none` still moves an edge."""
    for piece in pieces_of("tshirt", "none").pieces:
        net = Polygon(flatten_outline(piece.net)[0])
        assert Polygon(piece.cut.points).symmetric_difference(net).area < 1e-12


@pytest.mark.parametrize(
    "text", ["hem", "hem=", "hem=nan", "hem=-1", "hem=1e3", "collar=10", '{"hem": [1]}', "{", "hem,1,2", "fold=3"]
)
def test_wrong_allowances_are_refused(text):
    """Broken where nonsense is taken for a width."""
    with pytest.raises(AllowanceBad):
        read_allowances(text)


def test_allowances_are_read_from_text_json_and_csv():
    """Broken where the three ways to write the same disagree, or what is not named loses its default."""
    ways = ["hem=30, seam=12", '{"hem": 30, "seam": 12}', "hem,30\nseam,12\n"]
    assert len({read_allowances(way).describe() for way in ways}) == 1
    widths = read_allowances(ways[0]).widths
    assert (widths[EdgeUse.HEM], widths[EdgeUse.SEAM], widths[EdgeUse.NECK]) == (0.03, 0.012, 0.01)
    assert read_allowances("none").describe() == "none"
    assert read_allowances(read_allowances("hem=30").describe()).widths[EdgeUse.HEM] == 0.03


@pytest.mark.parametrize(
    ("text", "seam", "hem"),
    [
        ("15mm", 0.015, 0.025),
        ("5/8in", 0.015875, 0.025),
        ("seam=5/8in,hem=1 1/2in", 0.015875, 0.0381),
        ('{"seam": "0.5in", "hem": "2.5cm"}', 0.0127, 0.025),
        ("seam,3/8in\nhem,40", 0.009525, 0.04),
    ],
)
def test_widths_have_units(text, seam, hem):
    """Broken where an inch is taken for a millimetre, or one width for all is lost on a facing's edge."""
    widths = read_allowances(text).widths
    assert (widths[EdgeUse.SEAM], widths[EdgeUse.HEM]) == pytest.approx((seam, hem))
    if "=" not in text and "," not in text and ":" not in text:
        assert widths[EdgeUse.NECK] == widths[EdgeUse.FACED] == widths[EdgeUse.SEAM]
        assert widths[EdgeUse.DART] == 0.0 and widths[EdgeUse.ZIP] == 0.015
    assert read_allowances(read_allowances(text).describe()).widths == pytest.approx(dict(widths))


@pytest.mark.parametrize("text", ["0.625", "seam=0.625", "seam=5/8"])
def test_a_part_of_an_inch_is_asked_about(text):
    """Broken where 0.625, an inch's part, becomes an allowance of 0.6 mm that nobody can sew."""
    with pytest.raises(AllowanceBad, match="in"):
        read_allowances(text)


def square(name, edges=None, label=""):
    corners = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]])
    return Panel(name, corners, edges or (Edge(),) * 4, label=label)


def dart_piece(made):
    corners = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.12, 0.2], [0.10, 0.10], [0.08, 0.2], [0.0, 0.2]])
    panel = Panel("back", corners, (Edge(),) * 7)
    seam = Seam(EdgeRef("back", 3), EdgeRef("back", 4))
    (piece,) = make_pieces(Pattern("skirt", (panel,), (seam,)), made).pieces
    return piece


def test_a_dart_is_marked_and_not_cut():
    """Broken where the cut line follows a dart's legs instead of crossing its mouth."""
    piece = dart_piece(settings("open=10,seam=10"))
    assert [edge.use for edge in piece.edges].count(EdgeUse.DART) == 2
    assert Polygon(piece.cut.points).area >= 0.22**2
    assert len(piece.darts) == 1 and np.abs(piece.drills - [[0.1, 0.1]]).max() < 1e-3
    assert sum(notch.purpose == "dart" for notch in piece.notches) == 2


def test_a_dart_is_cut_as_it_is_folded():
    """Broken where a folded dart lacks cloth at its edge: its mouth has a peak, the edge's image in the fold."""
    piece = dart_piece(PieceSettings(read_allowances("none"), is_trued=False))
    leg = np.array([-0.02, 0.1]) / np.hypot(0.02, 0.1)
    along = 2.0 * leg * (np.array([-1.0, 0.0]) @ leg) - np.array([-1.0, 0.0])
    peak = np.array([0.08, 0.2]) + 0.02 / along[0] * along
    mouth = Polygon([[0.12, 0.2], peak, [0.08, 0.2]])
    square = Polygon([[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]])
    assert Polygon(piece.cut.points).symmetric_difference(square.union(mouth)).area < 1e-9


def test_hostile_names_become_plain_ones():
    """Broken where a panel's name reaches a file as it is: a line break there is a record of its own."""
    names = ["front\n0\nEOF", "ärmel links", "перед", "x" * 300, "front 0 EOF", "\x1b[2J"]
    panels = tuple(square(name) for name in names)
    pieces = make_pieces(Pattern("p", panels, ())).pieces
    found = [piece.name for piece in pieces]
    assert len(set(found)) == len(names)
    assert all(1 <= len(name) <= 20 and set(name) <= set("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") for name in found)
