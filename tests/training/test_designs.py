"""Drawn cuts: every collar, hood and front is drawn, can be drafted and worn, and stays turned over."""

from collections import Counter

import numpy as np
import pytest
from garmentq.core.body.template import load_template
from garmentq.core.garment.creases import mark_turned_faces
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.parts.cut import Collar, Cuff, Front, Hood, HoodWorn, Shaping, Skirt, Vent
from garmentq.core.garment.templates import draft_template
from garmentq.core.geometry.geometry import face_normals
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.people.part import Part
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.training import designs, persons, wardrobe
from garmentq.training.accessories import draw_accessories
from garmentq.training.designs import (
    DRESS_FINISHES,
    HELD_OUT,
    OUTER_FINISHES,
    SKIRTS,
    TOP_FINISHES,
    TOP_VENTS,
    Piece,
    draw_outfit,
)
from garmentq.training.wardrobe import goes_around_arms, grid_of, put_on, take_pose
from garmentq.training.wearer import at_rest, pose_angles, stand

DRAWS = 600
SHIRT = "long_sleeve_tshirt+"


@pytest.fixture(scope="module")
def wearer():
    """Return the built-in body and a wearer in the T-pose."""
    template = load_template()
    return template, at_rest(stand(template, template.means["female"], np.zeros((24, 3))))


@pytest.fixture(scope="module")
def drawn(wearer):
    """Return the garments of many persons."""
    measures, rng = measure_wearer(wearer[1]), np.random.default_rng(0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(designs, "measure_wearer", lambda body: measures)
        return [piece for _ in range(DRAWS) for piece in draw_outfit(wearer[1], rng, False)]


def test_people_wear_every_collar_hood_and_front(drawn):
    """Broken where a choice is never drawn, collars are rare or the rule, outer layers are closed, or held-out skirts
    are trained on."""
    cuts = [piece.cut for piece in drawn]
    assert {cut.collar for cut in cuts} == set(Collar)
    assert {cut.hood for cut in cuts} == set(Hood)
    assert {cut.front for cut in cuts} == set(Front)
    assert {cut.hood_worn for cut in cuts if cut.hood is not Hood.NONE} == set(HoodWorn)
    tops = [piece.is_finished for piece in drawn if piece.part is Part.UPPER]
    assert 0.2 < np.mean(tops) < 0.45
    fronts = Counter(piece.cut.front for piece in drawn if piece.part is Part.OUTER)
    assert fronts[Front.OPEN] > 0.4 * fronts.total()
    assert Front.NONE not in fronts
    assert not any(piece.template.startswith(HELD_OUT) for piece in drawn)


def test_what_is_drawn_can_be_drafted(drawn):
    """Broken where parts are drawn together that cannot be sewn to each other: the garment would be left out."""
    for name in {piece.template for piece in drawn}:
        assert draft_template(name, BodyMeasures()).panels


def test_people_wear_wraps_vents_shirt_cuffs_and_gathers(drawn):
    """Broken where one of them is never drawn or the rule, or a hem or a cuff that is finished is cut off."""
    cuts = {part: [piece.cut for piece in drawn if piece.part is part] for part in Part}
    for part, least, most in ((Part.UPPER, 0.005, 0.08), (Part.ONE_PIECE, 0.02, 0.25)):
        assert least < np.mean([cut.front is Front.WRAP for cut in cuts[part]]) < most
    assert {cut.vent for cut in cuts[Part.UPPER]} == {cut.vent for cut in cuts[Part.LOWER]} == set(Vent)
    shirts = [cut for cut in cuts[Part.UPPER] if cut.collar is Collar.SHIRT and cut.sleeve == "long"]
    assert 0.5 < np.mean([cut.cuff is Cuff.SHIRT for cut in shirts]) < 1.0
    assert any(cut.skirt is Skirt.GATHERED for cut in cuts[Part.LOWER])
    for part in (Part.LOWER, Part.ONE_PIECE):
        assert 0.0 < np.mean([cut.shaping is Shaping.GATHERS for cut in cuts[part]]) < 0.2


@pytest.mark.parametrize("shares", [TOP_FINISHES, OUTER_FINISHES, DRESS_FINISHES, SKIRTS, TOP_VENTS])
def test_shares_are_of_a_whole(shares):
    """Broken where a share is changed and the others are not: the stated ones would not be those that are drawn."""
    assert sum(shares.values()) == pytest.approx(1.0)


def wear(wearer, monkeypatch, parts, part=Part.UPPER, pose="A"):
    """Put a long-sleeved top with other parts on and take a pose; return it on the T-pose, its layer, the body."""
    template, rest = wearer
    monkeypatch.setattr(wardrobe, "NODES", 600)
    monkeypatch.setattr(wardrobe, "draw_trims", lambda *_: [])
    (one,) = put_on([Piece(SHIRT + parts, part, measure_wearer(rest))], rest)
    body = stand(template, template.means["female"], pose_angles(pose))
    (layer,) = take_pose([one], body, grid_of(body), np.random.default_rng(0))
    return one, layer, body


@pytest.mark.parametrize(
    ("parts", "part", "pose"),
    [
        ("collar=shirt,front=buttons", Part.UPPER, "A"),
        pytest.param("collar=polo,front=placket", Part.UPPER, "up", marks=pytest.mark.nightly),
        pytest.param("collar=convertible,front=buttons", Part.UPPER, "hips", marks=pytest.mark.nightly),
        pytest.param("collar=notched,front=open", Part.OUTER, "stride", marks=pytest.mark.nightly),
        pytest.param("collar=shawl,front=open", Part.OUTER, "forward", marks=pytest.mark.nightly),
    ],
)
def test_collars_stay_turned_in_a_pose(wearer, monkeypatch, parts, part, pose):
    """Broken where a fall unfolds or sinks into its garment as it is carried into a pose, is another garment than that,
    or shows its inside to a scanner."""
    one, layer, body = wear(wearer, monkeypatch, parts, part, pose)
    assert layer.part is part
    vertices, faces = layer.mesh
    is_turned = np.repeat(mark_turned_faces(one.garment), 4)
    assert len(faces) == len(is_turned)
    middles, worn = vertices[faces].mean(axis=1), faces[~is_turned]
    assert (TriangleSurface(vertices, worn).heights(middles[is_turned]) > 0.0).mean() > 0.8
    normals = face_normals(vertices, faces)[0][is_turned]
    away = grid_of(body).measure(middles[is_turned])[1]
    assert ((normals * away).sum(axis=1) > 0.0).mean() > 0.9


@pytest.mark.parametrize(
    ("parts", "pose"),
    [("front=wrap,neckline=v", "A"), pytest.param("front=wrap,neckline=v,vent=sides", "up", marks=pytest.mark.nightly)],
)
def test_the_outer_front_of_a_wrap_stays_outside(wearer, monkeypatch, parts, pose):
    """Broken where the fronts pass through each other as a person takes a pose: a scanner would see the inner one."""
    one, layer, _ = wear(wearer, monkeypatch, parts, pose=pose)
    pattern = one.garment.pattern
    panel = np.repeat(one.garment.panel_of_uv[one.garment.uv_faces[:, 0]], 4)
    outer, inner = ([p.name for p in pattern.panels].index(name) for name in ("front_right", "front_left"))
    vertices, faces = layer.mesh
    middles = vertices[faces[panel == inner]].mean(axis=1)
    over = TriangleSurface(vertices, faces[panel == outer])
    found = over.closest(middles)
    covered = (found.distance < 0.02) & ~over.border_faces[found.face]
    assert covered.mean() > 0.2
    assert (over.heights(middles[covered]) < 0.0).mean() > 0.9


@pytest.mark.parametrize(
    ("parts", "is_up"),
    [
        pytest.param("hood=two,front=zip", False, marks=pytest.mark.nightly),
        ("hood=three,hood_worn=up,hem_band=rib,cuff=rib", True),
        pytest.param("hood=two,hood_worn=up,front=open", True, marks=pytest.mark.nightly),
    ],
)
def test_hoods_are_on_the_head_or_behind_the_neck(wearer, monkeypatch, parts, is_up):
    """Broken where a hood falls off as it is carried into a pose, or hair and hats show through one on the head."""
    _, layer, body = wear(wearer, monkeypatch, parts)
    crown = body.vertices[:, 1].max()
    assert layer.is_on_head == is_up
    assert (layer.mesh[0][:, 1].max() > crown) == is_up
    if not is_up:
        return
    surface = TriangleSurface(*layer.mesh)
    for seed in range(6):
        for other in draw_accessories(load_template(), body, [layer], np.random.default_rng(seed)):
            top = other.mesh[0][other.mesh[0][:, 1] > crown]
            if len(top) and other.part is not Part.OTHER:
                assert (surface.heights(top) < 0.01).all()


def test_sleeves_without_arms_are_noticed(wearer, monkeypatch):
    """Broken where a garment that came off its arms while it was put on is scanned beside them."""
    rest = wearer[1]
    monkeypatch.setattr(wardrobe, "NODES", 400)
    (one,) = put_on([Piece("tshirt", Part.UPPER, measure_wearer(rest))], rest)
    garment = one.garment.at(one.nodes)
    assert goes_around_arms(garment, rest)
    assert not goes_around_arms(garment.at(one.nodes - [0.0, 0.25, 0.0]), rest)


def test_only_those_are_drawn_who_are_asked_for(wearer, monkeypatch):
    """Broken where a set of collars, hoods and fronts holds persons without: its share of them would be unknown."""
    piece = Piece("tshirt", Part.UPPER, measure_wearer(wearer[1]))
    monkeypatch.setattr(persons, "draw_clothes", lambda *_: ([], [piece]))
    monkeypatch.setattr(persons, "put_on", lambda *_: pytest.fail("he is dressed for nothing"))
    assert not list(persons.simulate(0, 1, finished=True))
