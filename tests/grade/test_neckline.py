"""A scan's neckline is told by the shape of its contour, and the base pattern is cut so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.curves import edge_points
from garmentq.core.garment.neckline_fit import (
    NecklineSettings,
    _curvature_beside,
    _rank,
    _Turns,
    fit_necklines,
)
from garmentq.core.garment.parts.cut import Neckline, PartsConflict
from garmentq.core.garment.parts.necklines import NecklineCut, corner_turn, neckline_points
from garmentq.core.garment.reading import Reading
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import rim_turns
from garmentq.core.recover.grade.choice import choose_cut
from garmentq.core.recover.grade.proportion import find_proportions
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.recover.start import find_template
from garmentq.core.scan.contours.neck import unroll_neck
from garmentq.core.scan.contours.target import Contour, Target
from garmentq.core.scan.pieces import ScanInput
from garmentq.core.scan.scan import Scan

BODY = builtin_body("builtin:female,height=1.70")


def neck_target(
    front: NecklineCut, back: NecklineCut, *, noise: float = 0.0, turn: float = 0.0, lean: float = 0.0
) -> Target:
    """Return a target whose neck contour is two drafted necklines, laid on a chest that leans as cylinders do.

    The front's edges lean in by `lean` of their height, as straps do that are nearer to each other on the shoulders.
    """
    halves = []
    for throat, sign in ((front, 1.0), (back, -1.0)):
        line = neckline_points(throat, 0.10, 40)
        if sign > 0:
            line[:, 0] *= 1.0 - lean * line[:, 1] / line[0, 0]
        slope = np.radians(25.0)
        halves.append(np.c_[line[:, 0], 1.40 + line[:, 1] * np.cos(slope), -sign * line[:, 1] * np.sin(slope)])
    ahead, behind = halves
    flip = np.array([-1.0, 1.0, 1.0])
    loop = np.concatenate([ahead[:-1], (ahead * flip)[:0:-1], (behind * flip)[:-1], behind[:0:-1]])
    loop += noise * np.random.default_rng(3).standard_normal(loop.shape)
    around = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    neck = Contour("neck", np.arange(len(loop)), 0.6)
    others = tuple(Contour(name, np.arange(4), length) for name, length in TSHIRT.items())
    return Target(loop @ around.T, np.zeros((0, 3), int), loop, (neck, *others), (), "tshirt")


TSHIRT = {"hem": 1.02, "cuff.left": 0.35, "cuff.right": 0.35}
"""The other contours of the T-shirt, as the library has them."""

CREW_BACK = NecklineCut.at_back(Neckline.CREW)


@pytest.mark.parametrize("kind", [Neckline.CREW, Neckline.SCOOP, Neckline.V, Neckline.SQUARE, Neckline.BOAT])
def test_each_neckline_is_told_from_the_others(kind):
    """Breaks where a line is taken for another: 1 mm of noise is a scanner's, and teeth are smoothed away."""
    fits = fit_necklines(neck_target(NecklineCut.at_front(kind), CREW_BACK, noise=0.001), BODY)
    assert fits is not None
    assert fits.front[0].neckline.kind is kind
    assert fits.front[0].misfit < 0.04
    assert fits.back[0].neckline.kind is Neckline.CREW


@pytest.mark.parametrize("lean", [0.1, 0.3])
def test_a_square_neckline_may_be_wider_below(lean):
    """Broken where side neck points are looked for at the lower corners, so that a square is a boat in front."""
    square = NecklineCut.at_front(Neckline.SQUARE)
    fits = fit_necklines(neck_target(square, CREW_BACK, lean=lean), BODY)
    assert fits is not None and fits.front[0].neckline.kind is Neckline.SQUARE
    assert fits.front[0].neckline.depth == pytest.approx(square.depth, abs=0.01)
    assert fits.back[0].neckline.kind is Neckline.CREW


def test_unrolled_lines_have_the_drafted_width_and_depth():
    """Breaks where the profile is not measured along the cloth, or front and back are exchanged."""
    target = neck_target(NecklineCut(Neckline.V, 0.18), CREW_BACK)
    lines = unroll_neck(target.vertices[: len(target.contours[0].vertices)], BODY)
    assert lines is not None
    assert lines.front[0] == pytest.approx([0.10, 0.0], abs=2e-3)
    assert lines.front[-1] == pytest.approx([0.0, 0.18], abs=6e-3)  # the corner is rounded
    assert lines.back[-1] == pytest.approx([0.0, 0.025], abs=5e-3)


def test_a_bowed_v_is_a_v_until_its_corner_is_gone():
    """Breaks where any pointed curve counts: a side that bows by 0.1 keeps a corner, a shallow round line has none."""
    bowed = fit_necklines(neck_target(NecklineCut(Neckline.V, 0.18, 0.08), CREW_BACK), BODY)
    assert bowed is not None and bowed.front[0].neckline.kind is Neckline.V
    assert bowed.front[0].neckline.bow == pytest.approx(0.08, abs=0.03)
    shallow = fit_necklines(neck_target(CREW_BACK, NecklineCut(Neckline.V, 0.05, 0.125)), BODY)
    assert shallow is not None and shallow.back[0].neckline.kind is not Neckline.V


def collared(target: Target, at: np.ndarray, out: np.ndarray) -> Target:
    """Return a target whose contours' points [m], shape [n, 3], have a ring of cloth around them, each `out` away."""
    apart = np.linalg.norm(at - np.roll(at, 1, axis=0), axis=1) > 1e-6
    at, out = at[apart], np.broadcast_to(out, at.shape)[apart]
    target = replace(target, contours=(replace(target.contours[0], vertices=np.arange(len(at))), *target.contours[1:]))
    here, rim = np.arange(len(at)), len(at) + np.arange(len(at))
    after, beyond = np.roll(here, -1), np.roll(rim, -1)
    faces = np.concatenate([np.c_[here, after, rim], np.c_[after, beyond, rim]])
    return replace(target, vertices=np.concatenate([at, at + out]), faces=faces)


@pytest.mark.parametrize("kind", [Neckline.V, Neckline.SQUARE])
@pytest.mark.parametrize("folded", [False, True])
def test_folds_make_no_corner(folded, kind):
    """Broken where a round neckline that hangs in folds has corners: cloth bent about a fold does not turn within."""
    target = neck_target(NecklineCut.at_front(Neckline.CREW), NecklineCut(kind, 0.12))
    loop, slope = target.vertices, np.radians(25.0)
    along = loop - loop.mean(axis=0)
    across = np.array([0.0, -np.sin(slope), np.cos(slope)])
    flat = 0.3 * (along - (along @ across)[:, None] * across)
    fits = fit_necklines(collared(target, loop, 0.03 * across if folded else flat), BODY)
    assert fits is not None and (fits.back[0].neckline.kind is kind) == (not folded)
    assert folded == (fits.back[0].neckline.kind in (Neckline.CREW, Neckline.SCOOP))


@pytest.mark.parametrize(("turn", "kind"), [(119.0, Neckline.V), (60.0, Neckline.SCOOP)])
def test_a_v_may_bulge(turn, kind):
    """Broken where a V whose sides bulge is round though the cloth has its point, or 2 mm of noise make that point."""
    drawn = [neckline_points(NecklineCut(each, 0.16), 0.10) * (1.0, -1.0) for each in (Neckline.SCOOP, Neckline.V)]
    at = np.linspace(0.0, 1.0, 100)
    alike = [
        np.stack([np.interp(at, np.linspace(0.0, 1.0, len(line)), column) for column in line.T], axis=1)
        for line in drawn
    ]
    line = 0.85 * alike[0] + 0.15 * alike[1]
    ranked = _rank(line, Neckline.BOAT, _Turns(np.radians(turn), np.radians(14.0)), NecklineSettings())
    assert ranked[0].neckline.kind is kind


@pytest.mark.parametrize(("tilt", "kind"), [(0.0, Neckline.V), (62.0, Neckline.SCOOP)])
def test_a_round_line_that_is_drawn_together_is_no_v(tilt, kind):
    """Broken where a V may turn within the cloth by no more than a round line of its width does."""
    bowed = NecklineCut(Neckline.V, 0.16, 0.125)
    target = neck_target(bowed, CREW_BACK)
    loop, slope = target.vertices, np.radians(25.0)
    front = np.array([0.0, np.sin(slope), np.cos(slope)])
    along = loop - loop.mean(axis=0)
    along -= (along @ front)[:, None] * front
    tilted = 0.3 * np.cos(np.radians(tilt)) * along + 0.03 * np.sin(np.radians(tilt)) * front
    fits = fit_necklines(collared(target, loop, tilted), BODY)
    assert corner_turn(bowed, 0.10) > NecklineSettings.v_turn
    assert fits is not None and fits.front[0].neckline.kind is kind


@pytest.mark.parametrize(("sag", "kind"), [(0.0, Neckline.SQUARE), (0.04, Neckline.SQUARE), (0.08, Neckline.SCOOP)])
def test_a_square_neckline_may_sag(sag, kind):
    """Broken where a square whose lower edge hangs is a scoop, or where a round line without corners is a square."""
    target = neck_target(NecklineCut(Neckline.SQUARE, 0.14), CREW_BACK)
    loop, slope = target.vertices.copy(), np.radians(25.0)
    down = np.array([0.0, -np.cos(slope), np.sin(slope)])
    low = (loop - [0.0, 1.40, 0.0]) @ down > 0.138
    wide = np.abs(loop[low, 0]).max()
    loop[low] += sag * (1.0 - (loop[low, 0] / wide) ** 2)[:, None] * down
    across = np.array([0.0, np.sin(slope), np.cos(slope)])
    along = loop - loop.mean(axis=0)
    fits = fit_necklines(collared(target, loop, 0.3 * (along - (along @ across)[:, None] * across)), BODY)
    assert fits is not None and fits.front[0].neckline.kind is kind
    if sag:
        assert (
            fits.front[0].misfit > NecklineSettings.clear_misfit * fits.front[1].misfit
        )  # by their lines alone it would be round


def test_dents_beside_a_contour_do_not_turn_it():
    """Broken where the curvature of dents is added to a contour's turn and not taken off, as Gauss and Bonnet say.

    The flat ring's inner rim is a circle of 6 cm, which turns by 2 pi; two rows of it are dented by 3 mm.
    """
    around, rows = 60, 12
    turn, out = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0.06, 0.12, rows), indexing="xy")
    vertices = np.stack([out * np.cos(turn), out * np.sin(turn), 0.0 * out], axis=-1).reshape(-1, 3)
    first = np.arange(around * (rows - 1))
    right = first - first % around + (first + 1) % around
    faces = np.concatenate(
        [np.stack([first, first + around, right], 1), np.stack([right, first + around, right + around], 1)]
    )
    vertices[: 2 * around, 2] += 3e-3 * np.random.default_rng(8).standard_normal(2 * around)
    rim = np.arange(around)
    dented = rim_turns(vertices[faces], faces, rim)
    target = Target(vertices, faces, vertices, (), (), "tshirt")
    assert abs(dented.sum() + 2 * np.pi) > np.radians(30.0)
    assert (dented + _curvature_beside(target, rim, NecklineSettings.strip_width)).sum() == pytest.approx(
        -2 * np.pi, abs=1e-9
    )


@pytest.mark.parametrize(("depth", "kind"), [(0.03, Neckline.CREW), (0.06, Neckline.SQUARE)])
def test_corners_beside_the_side_neck_points_make_no_square(depth, kind):
    """Broken where a shallow back, flat with tight ends as drapes show it, is square by corners that are its ends'."""
    at = np.linspace(0.0, 0.5 * np.pi, 200)
    line = np.stack([0.087 * np.cos(at) ** (2.0 / 3.0), depth * np.sin(at) ** (2.0 / 3.0)], axis=1)
    ranked = _rank(line, Neckline.CREW, _Turns(np.radians(5.0), np.radians(52.0)), NecklineSettings())
    assert ranked[0].neckline.kind is kind


def test_the_base_pattern_gets_the_corner_where_the_scan_has_it():
    """Breaks where the V lands in the back, or keeps the template's depth instead of the scan's proportion."""
    for front, back, name in (
        (NecklineCut(Neckline.V, 0.16), CREW_BACK, "tshirt+neckline=v"),
        (NecklineCut.at_front(Neckline.CREW), NecklineCut(Neckline.V, 0.13), "tshirt+back_neckline=v"),
        (NecklineCut(Neckline.CREW, 0.08), CREW_BACK, "tshirt"),
    ):
        choice = choose_cut(neck_target(front, back), BODY)
        assert choice.template == name == choice.candidates[0].template
        assert len(choice.candidates) == 3
    choice = choose_cut(neck_target(NecklineCut(Neckline.V, 0.16), CREW_BACK), BODY)
    panel = choice.pattern.panel("front")
    neck = [edge_points(panel, i, 8) for i, edge in enumerate(panel.edges) if edge.contour == "neck"]
    width, depth = np.ptp(np.concatenate(neck), axis=0)
    assert depth / (width / 2) == pytest.approx(1.6, rel=0.04)


def test_the_user_overrules_the_scan():
    """Breaks where --part is a hint only, or a part that trousers have no place for stops a person's recovery."""
    target = neck_target(NecklineCut(Neckline.V, 0.16), CREW_BACK)
    assert choose_cut(target, BODY, {"neckline": "square"}).template == "tshirt+neckline=square"
    assert choose_cut(target, BODY, {"neckline": "boat"}).template == "tshirt+neckline=boat"
    plain = choose_cut(target, BODY, {"neckline": "crew"})
    assert plain.template == "tshirt"
    assert np.array_equal(plain.pattern.points, load_template("tshirt").points)
    legs = tuple(Contour(name, np.arange(4), 0.4) for name in ("waist", "leg.left", "leg.right"))
    trousers = choose_cut(replace(target, contours=legs, category="trousers"), BODY, {"neckline": "v"})
    assert trousers.template == "trousers"
    assert "neckline" in trousers.notes[0]


@pytest.mark.parametrize("template", [None, "trousers"])
def test_a_choice_without_a_place_is_never_ignored(template):
    """Broken where --part neckline=v for trousers is dropped without a word, or stops the recovery of a person's."""
    legs = tuple(Contour(name, np.arange(4), 0.4) for name in ("waist", "leg.left", "leg.right"))
    target = replace(neck_target(CREW_BACK, CREW_BACK), contours=legs, category="trousers")
    settings = RecoverySettings(template=template, parts="neckline=v,waistband=band")
    alone = Request(Path("trousers.ply"), settings=settings)
    with pytest.raises(PartsConflict, match="choose legs, waistband"):
        find_template(alone, target, BODY)
    reading = Reading(ScanInput(Scan(target.vertices, target.faces), None), category="trousers")
    found = find_template(replace(alone, reading=reading), target, BODY)
    assert found.template == "trousers+waistband=band"
    assert found.notes[0] == "A trousers has no neckline; 'neckline=v' was left out."


def test_a_neck_that_cannot_be_trusted_changes_nothing():
    """Breaks where damage at the neck chooses the cut."""
    target = neck_target(NecklineCut(Neckline.V, 0.16), CREW_BACK)
    torn = replace(target, contours=(replace(target.contours[0], trusted=False), *target.contours[1:]))
    choice = choose_cut(torn, BODY)
    assert choice.template == "tshirt"
    assert np.array_equal(choice.pattern.points, load_template("tshirt").points)


def test_a_turned_wearer_has_the_same_neckline():
    """Breaks where left and right are the world's x instead of the wearer's."""
    turn = 0.6
    around = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    turned = replace(BODY, joints=BODY.joints @ around.T)
    straight = fit_necklines(neck_target(NecklineCut.at_front(Neckline.V), CREW_BACK), BODY)
    found = fit_necklines(neck_target(NecklineCut.at_front(Neckline.V), CREW_BACK, turn=turn), turned)
    assert straight is not None and found is not None
    assert found.front[0].neckline.kind is straight.front[0].neckline.kind
    assert found.front[0].misfit == pytest.approx(straight.front[0].misfit, abs=0.01)


@pytest.mark.parametrize(("name", "kept"), [("tshirt+neckline=v", 1), ("tshirt", 0)])
def test_a_v_is_kept_as_wide_as_the_back_neckline(name, kept):
    """Breaks where a V opens on its own: an example's front neck came out 295 mm wide at a back of 234."""
    pattern = load_template(name)
    ends = [edge_ends(pattern, face) for face in ("back", "front")]
    rules = find_proportions(pattern)
    ratios = zip(rules.widths, rules.width_ratios, strict=True)
    found = [ratio for pair, ratio in ratios if [set(one) for one in pair] == ends]
    assert found == pytest.approx([0.0] * kept)


def edge_ends(pattern, face: str) -> set[int]:
    """Return the numbers of the two side neck points of a panel."""
    panel, first = pattern.panel(face), pattern.first_points[face]
    neck = {i for i, edge in enumerate(panel.edges) if edge.contour == "neck"}
    ends = {i for i in neck if (i - 1) % len(panel.edges) not in neck}
    ends |= {(i + 1) % len(panel.edges) for i in neck if (i + 1) % len(panel.edges) not in neck}
    return {first + i for i in ends}
