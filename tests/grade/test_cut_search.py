"""The cut is told by girths within the surface and by the length of sleeves, and stays where these do not tell."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.parts.draft import draft_cut
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import find_cut
from garmentq.core.recover.grade.choice import choose_cut
from garmentq.core.recover.grade.cut_name import describe_cut_change, name_recovered
from garmentq.core.recover.grade.cut_search import CutFit, compare_girths, rank_fits
from garmentq.core.recover.grade.distances import limb_chain
from garmentq.core.recover.grade.girth_profile import GirthProfile, measure_girths, profile_pattern
from garmentq.core.recover.grade.sleeve_length import fit_sleeve
from garmentq.core.scan.contours.target import Contour, Target

BODY = builtin_body("builtin:female,height=1.70")

LARGER = replace(BodyMeasures(), waist=0.78, hip=1.05, hip_height=0.79, crotch_height=0.765)
"""Of somebody whom a garment was made for that another one wears: 5 to 8 % wider, and longer by 3 cm."""


def cone(sweep: float, folds: int = 0) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Return a circle skirt of a sweep [rad] 0.5 m long below a waist of 0.74 m, with its contours.

    Flat it is a sector of that angle; round it is the cone whose directions make up a curve of that length on the
    sphere, a circle, or one with folds.
    """
    around, along = 120, 26
    angle = np.linspace(0.0, 2.0 * np.pi, 40 * around, endpoint=False)
    low, high = 0.0, np.pi / 2

    def directions(tilt: float) -> np.ndarray:
        lean = tilt + 0.08 * np.cos(folds * angle) * (folds > 0)
        return np.stack([np.sin(lean) * np.cos(angle), -np.cos(lean), np.sin(lean) * np.sin(angle)], axis=1)

    def lengths(curve: np.ndarray) -> np.ndarray:
        return np.linalg.norm(np.roll(curve, -1, axis=0) - curve, axis=1)

    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if lengths(directions(middle)).sum() < sweep else (low, middle)
    curve = directions(low)
    arc = np.concatenate([[0.0], np.cumsum(lengths(curve))[:-1]])
    picked = curve[np.searchsorted(arc, np.linspace(0.0, sweep, around, endpoint=False))]
    radius = 0.74 / sweep + np.linspace(0.0, 0.5, along)
    vertices = (radius[:, None, None] * picked).reshape(-1, 3)
    vertices += [0.0, 1.07 - vertices[:around, 1].mean(), 0.0]
    grid = np.arange(around * along).reshape(along, around)
    a, b, c, d = grid[:-1], np.roll(grid, -1, 1)[:-1], np.roll(grid, -1, 1)[1:], grid[1:]
    faces = np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3), np.stack([a, c, d], 2).reshape(-1, 3)])
    return vertices, faces, {"waist": grid[0], "hem": grid[-1][::-1]}


def target_of(vertices: np.ndarray, faces: np.ndarray, loops: dict[str, np.ndarray]) -> Target:
    """Return a surface as the target of a skirt."""

    def length(loop: np.ndarray) -> float:
        return float(np.linalg.norm(vertices[loop] - vertices[np.roll(loop, 1)], axis=1).sum())

    contours = tuple(Contour(name, loop, length(loop)) for name, loop in sorted(loops.items()))
    return Target(vertices, faces, np.zeros_like(vertices), contours, (), "skirt")


@cache
def draft(name: str, larger: bool = False) -> GirthProfile:
    """Return the girths of a cut's flat pattern."""
    cut = draft_cut(find_cut(name), LARGER if larger else BodyMeasures())
    profile = profile_pattern(mesh_pattern(cut, 250, sweeps=0))
    assert profile is not None
    return profile


@pytest.mark.parametrize("folds", [0, 6])
def test_girths_are_those_of_the_flat_cloth(folds: int) -> None:
    """Breaks where girths are taken in space: folds keep a circle skirt's girth and make it narrower."""
    vertices, faces, loops = cone(np.pi, folds)
    profile = measure_girths(vertices[faces], faces, loops)
    assert profile is not None
    radius = 0.74 / np.pi + profile.distances
    assert profile.girths == pytest.approx(np.pi * radius, rel=0.01)
    assert profile.distances[-1] == pytest.approx(0.5 * (1.0 - 0.5 / len(radius)), abs=0.015)


def test_what_has_no_lower_end_has_no_girths() -> None:
    """Breaks where a surface that ends nowhere that is trusted is measured all the same."""
    vertices, faces, loops = cone(np.pi)
    assert measure_girths(vertices[faces], faces, {"waist": loops["waist"]}) is None
    assert measure_girths(vertices[faces[:0]], faces[:0], {}) is None


def test_a_stray_piece_changes_nothing() -> None:
    """Breaks where a button without a contour makes the system singular, or a loose band counts as the way down."""
    vertices, faces, loops = cone(np.pi)
    count = len(vertices)
    more = np.concatenate([vertices, [[0.5, 1.0, 0.0], [0.52, 1.0, 0.0], [0.5, 1.02, 0.0]]])
    stray = np.concatenate([faces, [[count, count + 1, count + 2]]])
    alone, both = (measure_girths(points[f], f, loops) for points, f in ((vertices, faces), (more, stray)))
    assert alone is not None and both is not None
    assert both.girths == pytest.approx(alone.girths, rel=1e-9)
    assert measure_girths(more[stray], stray, {**loops, "waist": np.arange(count, count + 3)}) is None


def test_a_corner_of_faces_without_area_changes_nothing() -> None:
    """Breaks where a node that only needles of no width hold to the cloth makes the system singular."""
    vertices, faces, loops = cone(np.pi)
    edge = faces[len(faces) // 2, :2]
    more = np.concatenate([vertices, vertices[edge].mean(axis=0, keepdims=True)])
    needles = np.concatenate([faces, [[edge[1], edge[0], len(vertices)]]])
    alone, both = (measure_girths(points[f], f, loops) for points, f in ((vertices, faces), (more, needles)))
    assert alone is not None and both is not None
    assert both.girths == pytest.approx(alone.girths, rel=1e-9)
    assert both.distances == pytest.approx(alone.distances, rel=1e-9)


def test_a_circle_skirt_is_cut_as_one() -> None:
    """Breaks where the nearest shipped template is taken for a cut that the parts have, or the user cannot overrule."""
    surface = target_of(*cone(np.pi))
    choice = choose_cut(surface, BODY)
    assert find_cut(choice.template) == CUTS["skirt"].choose({"skirt": "half-circle"})
    assert choice.candidates[0].misfit < 0.03
    assert len(choice.candidates) == 3
    wanted = choose_cut(surface, BODY, {"skirt": "a-line", "waistband": "none"})
    assert str(find_cut(wanted.template).skirt) == "a-line"
    torn = replace(surface, contours=tuple(replace(line, trusted=False) for line in surface.contours))
    assert choose_cut(torn, BODY).template in CUTS


@pytest.mark.parametrize(
    "names",
    [
        ["trousers", "trousers+legs=flared", "trousers+legs=wide"],
        ["dress", "dress+skirt=gathered,waist=seam"],
    ],
)
def test_another_size_is_the_same_cut(names: list[str]) -> None:
    """Breaks where size, or where hips and crotch sit, is taken for another cut."""
    for true in names:
        fits = [CutFit(name, find_cut(name), compare_girths(draft(true, True), draft(name))) for name in names]
        assert rank_fits(fits, fits[0].cut)[0].template == true


def test_what_is_not_clear_stays_as_contours_chose() -> None:
    """Breaks where noise chooses: a little nearer is no evidence, and of two alike the one with fewer changes is it."""
    usual, other, third = (find_cut(name) for name in ("skirt", "skirt+skirt=straight", "pencil_skirt"))

    def chosen(*misfits: float) -> object:
        fits = [CutFit("skirt", cut, misfit) for cut, misfit in zip((usual, other, third), misfits, strict=True)]
        return rank_fits(fits, usual)[0].cut

    assert chosen(0.030, 0.020, 0.020) is usual
    assert chosen(0.015, 0.001, 0.001) is usual
    assert chosen(0.080, 0.038, 0.080) is usual  # proportions, which grading mends
    assert chosen(0.080, 0.080, 0.040) is third  # a band, which it does not add
    assert chosen(0.080, 0.024, 0.022) is other
    assert chosen(0.080, 0.034, 0.015) is third
    assert rank_fits([CutFit("skirt", other, 0.01)], usual) == ()


def test_of_equal_girths_the_fewer_panels_are_taken() -> None:
    """Broken where six gores are as near to a skirt of two panels as four are: a hundredth of the misfit decided."""
    two, four = CUTS["skirt"], CUTS["four_panel_skirt"]
    fits = [
        CutFit("skirt", two, 0.060),
        CutFit("skirt", two.choose({"skirt": "gored"}), 0.012),
        CutFit("four_panel_skirt", four, 0.014),
    ]
    assert rank_fits(fits, two)[0].cut == four


@pytest.mark.parametrize(("share", "name"), [(0.24, "cap"), (0.37, "elbow"), (0.53, "elbow"), (0.95, "long")])
def test_a_sleeve_far_from_the_scans_length_is_left(share: float, name: str) -> None:
    """Breaks where every dress with cuffs gets the library's elbow sleeves, or one that grading mends is left."""
    loops = []
    for side in ("left", "right"):
        chain = limb_chain(f"cuff.{side}", BODY)
        way = np.linalg.norm(np.diff(chain[1:4], axis=0), axis=1)
        at = share * way.sum()
        middle = chain[1] + (chain[2] - chain[1]) * min(at / way[0], 1.0)
        middle = middle + (chain[3] - chain[2]) * max(at - way[0], 0.0) / way[1]
        turn = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
        loops.append(middle + 0.06 * np.stack([0.0 * turn, np.cos(turn), np.sin(turn)], axis=1))
    contours = tuple(Contour(f"cuff.{side}", np.arange(16) + 16 * i, 0.37) for i, side in enumerate(("left", "right")))
    target = Target(np.concatenate(loops), np.zeros((0, 3), int), np.concatenate(loops), contours, (), "dress")
    assert str(fit_sleeve(target, BODY, CUTS["sleeved_dress"]).sleeve) == name
    assert fit_sleeve(target, BODY, CUTS["dress"]) is CUTS["dress"]


@pytest.mark.parametrize(
    ("drawn", "template", "name"),
    [
        ("skirt+waistband=band", "pencil_skirt", "skirt+waistband=band"),
        ("trousers+legs=wide", "trousers", "trousers+legs=wide"),
        ("sleeved_jumpsuit+legs=wide", "sleeved_jumpsuit", "sleeved_jumpsuit+legs=wide"),
        ("skirt+skirt=straight", "pencil_skirt", "pencil_skirt"),  # 6 cm at the hem tell nothing
        ("trousers", "trousers", "trousers"),
        ("tshirt", "tshirt", "tshirt"),
    ],
)
def test_a_recovered_pattern_is_named_by_what_came_out(drawn: str, template: str, name: str) -> None:
    """Breaks where a pattern keeps the name of what it was graded from, or leaves it for one that is as near.

    What was recovered is drafted for another body than the wearer's.
    """
    pattern = draft_cut(find_cut(drawn), LARGER)
    assert name_recovered(pattern, template, BODY) == name
    assert bool(describe_cut_change(name, template)) == (name != template)


def test_what_the_user_chose_is_not_renamed() -> None:
    """Breaks where `--part skirt=pencil` is told as something else."""
    assert name_recovered(draft_cut(find_cut("skirt"), LARGER), "pencil_skirt", BODY, {"skirt"}) == "pencil_skirt"
