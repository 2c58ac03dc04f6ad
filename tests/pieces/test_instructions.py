"""A walk through the instructions: what a reader of the lines sews, in their order, is the garment."""

import re

import pytest
from garmentq.core.deliver.formats.cover_page import list_steps
from garmentq.core.garment.pattern import EdgeRef
from garmentq.core.garment.pieces.instructions import list_sewing_steps
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.pieces.piece import SEWN_EDGE_USES, EdgeUse
from garmentq.core.garment.pieces.trueing import true_pattern
from garmentq.core.garment.templates import load_template
from garmentq_pieces import TEMPLATES, imported, pieces_of

CUTS = [
    "tshirt+sleeve_head=raglan",
    "long_sleeve_tshirt+sleeve_head=set-in,cuff=shirt,collar=shirt,front=buttons,vent=sides",
    "tshirt+hood=three,hem_band=rib,cuff=rib",
    pytest.param("dress+skirt=tiered,waist=seam", marks=pytest.mark.nightly),
    pytest.param("skirt+skirt=gored,gores=8,waistband=band", marks=pytest.mark.nightly),
    pytest.param("tank+shaping=princess", marks=pytest.mark.nightly),
]

LINE = re.compile(
    r"(\d+) ([a-z][a-zA-Z0-9_ ]*?) ([\d.]+)(?: to ([\d.]+))? cm(, 2 x)?: ([A-Z0-9_, -]+?(?: to [A-Z0-9_, -]+)?); .+"
)


def read(pieces):
    """Return the steps as a reader finds them in the lines: number, name, lengths [cm], count, pieces."""
    head, *lines = list_steps(pieces)
    assert head == "Sewing order"
    found = [LINE.fullmatch(line) for line in lines]
    assert all(found), [line for line, match in zip(lines, found, strict=True) if not match]
    return found


@pytest.mark.parametrize("name", TEMPLATES + CUTS)
def test_each_seam_is_sewn_once_by_its_name(name):
    """Broken where a seam is left out, is listed again once it is closed, or two steps cannot be told apart."""
    pieces, pattern = pieces_of(name), true_pattern(load_template(name)).pattern
    steps = read(pieces)
    assert [int(step[1]) for step in steps] == list(range(1, len(steps) + 1))
    names = [step[2] for step in steps]
    assert len(set(names)) == len(names)
    assert not any(word in name for name in names for word in ("scye", ".", "outseam"))
    closed: set[frozenset[EdgeRef]] = set()
    edges = [edge for piece in pieces.pieces for edge in piece.edges]
    partner = {ref: frozenset((seam.a, seam.b)) for seam in pattern.seams for ref in (seam.a, seam.b)}
    for step in steps:
        seams = [seam for seam in pieces.seams if seam.name == step[2]]
        assert {seam.step for seam in seams} <= {int(step[1])}
        for seam in seams:
            sides = [
                {
                    getattr(pieces.pieces[part.piece].edges[part.edge], "mirror" if part.mirrored else "source")
                    for part in side
                }
                for side in seam.sides
            ]
            joined = frozenset(ref for side in sides for ref in side)
            assert joined not in closed and all(partner[ref] == joined for ref in joined)
            closed.add(joined)
    sewn = {ref for joined in closed for ref in joined}
    drawn = {ref for edge in edges for ref in (edge.source, edge.mirror) if edge.use in (*SEWN_EDGE_USES, EdgeUse.DART)}
    assert sewn == drawn - {None}


@pytest.mark.parametrize(
    ("name", "order"),
    [
        ("tshirt", ["shoulder seam", "armhole seam", "sleeve seam"]),
        ("tshirt", ["armhole seam", "side seam"]),
        ("tshirt+sleeve_head=set-in", ["side seam", "armhole seam"]),
        ("tshirt+sleeve_head=set-in", ["sleeve seam", "armhole seam"]),
        ("tshirt+sleeve_head=raglan", ["armhole seam", "overarm seam"]),
        ("dress+skirt=tiered,waist=seam", ["tier 1 side seam", "tier 1 seam"]),
        ("dress+skirt=tiered,waist=seam", ["side seam", "waist seam"]),
        ("tank+shaping=princess", ["front princess seam", "shoulder seam", "side seam"]),
        ("skirt+skirt=gored,gores=8,waistband=band", ["centre back seam", "waistband seam"]),
        ("tshirt+hood=three,hem_band=rib,cuff=rib", ["hood crown seam", "neck seam"]),
        ("tshirt+hood=three,hem_band=rib,cuff=rib", ["side seam", "hem rib seam", "hem"]),
        ("trousers", ["back crotch seam", "inseam", "leg hem"]),
    ],
)
def test_what_a_seam_crosses_is_sewn_before_it(name, order):
    """Broken where a seam runs over two pieces that no earlier step has joined, or an eased cap is set in flat."""
    names = [step.name for step in list_sewing_steps(pieces_of(name))]
    found = [names.index(one) for one in order if one in names]
    assert found == sorted(found) and len(found) >= len(order) - ("hem" in order)


@pytest.mark.parametrize("name", ["tshirt", "trousers", "jumpsuit"])
def test_a_file_without_labels_has_the_same_seams(name):
    """Broken where seams of a pattern from elsewhere are called by the pieces, since its file names none."""
    drafted, found = ({seam.name for seam in pieces.seams} for pieces in (pieces_of(name), make_pieces(imported(name))))
    assert {one for one in drafted if "crotch" not in one} <= found


def test_lengths_are_those_of_the_pieces():
    """Broken where left and right are added up, or a gathered seam says one length only."""
    steps = {step[2]: step for step in read(pieces_of("tshirt"))}
    seams = pieces_of("tshirt").seams
    shoulder = next(seam for seam in seams if seam.name == "shoulder seam")
    assert steps["shoulder seam"][5] and float(steps["shoulder seam"][3]) == pytest.approx(
        100 * shoulder.lengths[0], abs=0.051
    )
    eased = {step[2]: step for step in read(pieces_of("tshirt+sleeve_head=set-in"))}["armhole seam"]
    assert float(eased[3]) > float(eased[4]) > 30.0
