"""Pieces that finish openings, against the edges that they are sewn to; outlines are checked by shapely."""

import pytest
from garmentq.core.garment.curves import edge_length
from garmentq.core.garment.parts.collars import NECK_RIB_WIDTH
from garmentq.core.garment.parts.ribs import RIB_RATIO
from garmentq.core.garment.pieces.finishing import FRONT_FACING_DEPTH, NECK_FACING_DEPTH
from garmentq.core.garment.pieces.flatten import flatten_edge, flatten_outline
from garmentq.core.garment.pieces.instructions import list_sewing_steps
from garmentq.core.garment.pieces.layout import lay_on_cloth, list_copies
from garmentq.core.garment.pieces.make import PieceSettings, Style, make_pieces
from garmentq.core.garment.pieces.naming import extend_name, number_name, say_name
from garmentq.core.garment.pieces.piece import EdgeUse, Material
from garmentq.core.garment.templates import load_template
from shapely import LineString, Point, Polygon

KNIT = Style(is_stretchy=True)


def made(name, style=None, fold=False):
    return make_pieces(load_template(name), PieceSettings(fold=fold), style)


@pytest.mark.parametrize(
    ("name", "faced", "depth"),
    [
        ("tshirt", ["FRONT_NECK_FACING", "BACK_NECK_FACING"], NECK_FACING_DEPTH),
        ("tshirt+neckline=v", ["FRONT_NECK_FACING", "BACK_NECK_FACING"], NECK_FACING_DEPTH),
        ("tshirt+front=open,neckline=v", ["FRONT_FACING", "BACK_NECK_FACING"], FRONT_FACING_DEPTH),
        ("tshirt+collar=shirt,front=buttons", ["FRONT_FACING"], FRONT_FACING_DEPTH),
    ],
)
@pytest.mark.parametrize("fold", [False, True])
def test_facings_lie_on_their_pieces(name, faced, depth, fold):
    """Broken where a facing is no part of the piece that it faces, is not as deep as said, or its edge has another
    length."""
    found = made(name, fold=fold)
    assert [piece.name for piece in found.drafted] == faced
    for seam in (one for one in found.finishes if one.name.endswith("facing seam")):
        garment, piece = seam.sides[0], found.cut_pieces[seam.sides[1][0].piece]
        faced_piece = found.pieces[garment[0].piece]
        net, whole = (Polygon(flatten_outline(one.net, 1e-5)[0]) for one in (piece, faced_piece))
        assert net.is_valid and net.difference(whole.buffer(1e-4)).area < 1e-8
        assert seam.lengths[0] == pytest.approx(seam.lengths[1], abs=1e-6)
        lines = [LineString(flatten_edge(faced_piece.net, side.edge)) for side in garment]
        inner = [
            min(line.distance(Point(point)) for line in lines)
            for i, edge in enumerate(piece.edges)
            if edge.use is EdgeUse.OPEN
            for point in flatten_edge(piece.net, i)[1:-1]
        ]
        assert max(inner) < depth + 1e-3 and max(inner) - min(inner) < 2e-3
        assert piece.interfaced == piece.quantity == faced_piece.quantity and piece.pair == faced_piece.pair
        assert (piece.fold is None) == (faced_piece.fold is None)


def test_a_knit_has_ribs():
    """Broken where a T-shirt has no neckband, or it is not shorter than the neck by the ratio of ribs."""
    found = made("tank", KNIT)
    neck, arm = found.drafted
    assert (neck.name, arm.name, arm.quantity, arm.pair) == ("NECK_RIB", "ARMHOLE_RIB", 2, True)
    assert {piece.material for piece in found.drafted} == {Material.RIB}
    seams = {seam.name: seam for seam in found.finishes}
    for piece, name in ((neck, "neck rib seam"), (arm, "armhole rib seam")):
        assert seams[name].lengths[1] == pytest.approx(RIB_RATIO * seams[name].lengths[0])
        assert edge_length(piece.net, 1) == pytest.approx(2.0 * NECK_RIB_WIDTH)
        assert Polygon(piece.cut.points).area > Polygon(flatten_outline(piece.net)[0]).area
    names = [step.name for step in list_sewing_steps(found)]
    assert "neck rib seam" in names and "neck edge" not in names
    assert not any("neck" in line for line in found.missing)
    assert len(list_copies(found.cut_pieces)) == len(list_copies(found.pieces)), "ribs are cut of rib"


def test_what_has_an_inner_half_is_cut_twice():
    """Broken where a waistband, cuff or collar is cut once, or its inner half is not mirrored where it has to be."""
    band = next(piece for piece in made("pencil_skirt").pieces if piece.name == "BAND")
    assert (band.quantity, band.pair, band.interfaced) == (2, True, 1)
    assert {edge.use for edge in band.edges} == {EdgeUse.SEAM, EdgeUse.FACED}
    cuff = next(piece for piece in made("long_sleeve_tshirt+cuff=band").pieces if piece.name == "CUFF")
    assert (cuff.quantity, cuff.interfaced) == (4, 2)
    elastic = next(piece for piece in made("skirt+waistband=elastic").pieces if piece.name == "BAND")
    assert elastic.quantity == 2 and elastic.interfaced == 0


@pytest.mark.parametrize("fold", [False, True])
@pytest.mark.parametrize(
    ("name", "seams"),
    [
        (
            "long_sleeve_tshirt+cuff=shirt,collar=shirt,front=buttons",
            {"inner collar seam": ({"COLLAR", "COLLAR FALL"}, 1), "inner cuff seam": ({"CUFF"}, 2)},
        ),
        ("pencil_skirt", {"inner waistband seam": ({"BAND"}, 1)}),
        ("skirt+waistband=elastic", {"inner waistband seam": ({"BAND"}, 1)}),
        ("tshirt+collar=stand", {"inner collar seam": ({"COLLAR"}, 1)}),
    ],
)
def test_inner_layers_are_sewn_by_name(name, seams, fold):
    """Broken where the inner layer of a cuff, a waistband or a collar has no step, or a step of another length than
    the free and closed edges of one outer layer."""
    found = made(name, fold=fold)
    steps = {step.name: step for step in list_sewing_steps(found)}
    assert "faced edges" not in steps
    for seam, (names, count) in seams.items():
        step = steps[seam]
        turned = [
            edge_length(piece.net, i) * (1 if piece.fold is None else 2)
            for piece in found.pieces
            if say_name(piece.name) in names
            for i, edge in enumerate(piece.edges)
            if edge.use in (EdgeUse.FACED, EdgeUse.BUTTONS)
        ]
        assert {*step.pieces[0]} == names and step.count == count
        assert step.lengths == pytest.approx((sum(turned), sum(turned)))


@pytest.mark.parametrize("name", ["tshirt+hood=three", "long_sleeve_tshirt+hood=two"])
def test_a_hood_of_cloth_that_frays_is_lined(name):
    """Broken where the lining of a hood has other outlines than the hood, its face another length, or a knit's hood
    has one too."""
    found = made(name)
    hoods = [piece for piece in found.pieces if piece.net.label == "hood"]
    linings = [piece for piece in found.drafted if piece.name.endswith("_LINING")]
    assert [(one.quantity, one.pair) for one in linings] == [(one.quantity, one.pair) for one in hoods]
    for one, other in zip(linings, hoods, strict=True):
        assert Polygon(one.cut.points).symmetric_difference(Polygon(other.cut.points)).area < 1e-9
        assert len(one.notches) == len(other.notches)
    seams = [seam for seam in found.finishes if seam.name == "hood lining seam"]
    assert all(seam.lengths[0] == pytest.approx(seam.lengths[1]) for seam in seams)
    knit = made(name, KNIT)
    assert {"HOOD_CASING"} == {piece.name for piece in knit.drafted if piece.name.startswith("HOOD")}
    casing = sum(seam.lengths[0] for seam in knit.finishes if seam.name == "hood casing seam")
    assert sum(seam.lengths[0] for seam in seams) == pytest.approx(casing)
    assert not any("hood" in line for line in found.missing) and any("hood" in line for line in knit.missing)


def test_no_two_pieces_have_one_name():
    """Broken where a file's reader takes two pieces for one, since a long name was cut short."""
    assert extend_name("HOOD_CENTRE_BACK", "LINING") == "HOOD_CENTRE_LINING"
    assert extend_name("X" * 20, "NECK_FACING") == "X" * 8 + "_NECK_FACING"
    assert number_name("X" * 20, ["X" * 20]) == "X" * 18 + "_2"


def test_bindings_are_cut_on_the_bias():
    """Broken where a binding lies along the warp in the lay, or is not as long as its armhole."""
    found = made("tank")
    binding = next(piece for piece in found.drafted if piece.name == "ARMHOLE_BINDING")
    assert binding.is_bias and binding.quantity == 2
    seam = next(seam for seam in found.finishes if seam.name == "armhole binding seam")
    assert seam.lengths[0] == pytest.approx(seam.lengths[1]) and seam.is_paired
    (copy, _) = list_copies((binding,))
    wide, tall = copy.outline.max(axis=0) - copy.outline.min(axis=0)
    assert wide == pytest.approx(tall)
    assert lay_on_cloth(found.cut_pieces).length > lay_on_cloth(found.pieces).length


def test_nothing_is_drafted_that_is_not_asked_for():
    """Broken where pieces to be compared with a pattern's panels hold others, or the openings are then not listed."""
    bare = make_pieces(load_template("tank"), PieceSettings(is_finished=False))
    assert not bare.drafted and not bare.finishes and any("neck" in line for line in bare.missing)
