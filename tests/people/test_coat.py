"""An outer layer with its front open: found by its two edges and two colours, and told from what is worn below it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.people.cloths import overlap_of_cloths
from garmentq.core.people.coat import Coat, find_coat, open_evidence
from garmentq.core.people.colour import link_alike
from garmentq.core.people.confidence import MIN_OUTFIT_LOG_ODDS
from garmentq.core.people.diffusion import link_points
from garmentq.core.people.features import describe_points
from garmentq.core.people.front import find_path
from garmentq.core.people.looseness import loose_evidence, measure_looseness
from garmentq.core.people.outfit import above_waist_probability, condition_on_outfit, rank_outfits
from garmentq.core.people.part import PARTS, Part
from garmentq.core.people.points import sample_person
from garmentq.core.people.rules import WaistShown, waist_evidence
from garmentq.core.scan.raw import RawScan
from scipy.spatial import cKDTree

TAN, NAVY, CREAM, GREY = (0.76, 0.60, 0.48), (0.10, 0.14, 0.32), (0.90, 0.86, 0.76), (0.45, 0.47, 0.45)


@dataclass(frozen=True)
class Fit:
    """Stand for a fit: the body is known."""

    body: Body


@dataclass(frozen=True)
class Worn:
    """What a person was told to wear: true parts of the samples, what is known of a coat, the outfit and its labels."""

    part: np.ndarray
    coat: Coat
    outfit: tuple[Part, ...]
    label: np.ndarray


def wear(inner: tuple[float, ...], legs: tuple[float, ...], coat: tuple[float, ...], gap: float) -> Worn:
    """Take a person apart who wears a jacket to below the hips, open by twice `gap`, over a top and trousers.

    The posterior is what geometry gives: a top above the jacket's hem, which is the only ring, and trousers below.
    """
    body = builtin_body("builtin:female,pose=A")
    rest = body.rest_vertices
    hip, neck, ankle, wrist = (body.rest_joints[k] for k in (1, 12, 7, 20))
    y, x = rest[:, 1], np.abs(rest[:, 0])
    cloth = (y > ankle[1] + 0.05) & (y < neck[1] - 0.03) & (x < wrist[0] - 0.05)
    below = y < hip[1] - 0.08
    front = (rest[:, 2] > body.rest_joints[0, 2]) & (x < gap)
    low = below | front & (y < hip[1] + 0.10)
    part = np.select([~cloth, low, front], [Part.SKIN, Part.LOWER, Part.UPPER], Part.OUTER)
    shown = {Part.SKIN: TAN, Part.LOWER: legs, Part.UPPER: inner, Part.OUTER: coat}
    rgb = np.array([shown[Part(value)] for value in part])
    rgb = (rgb + np.random.default_rng(0).normal(0.0, 0.02, rgb.shape)).clip(0.0, 1.0)
    height = np.select([part == Part.OUTER, part != Part.SKIN], [0.014, 0.006], 0.0)
    every, fit = np.arange(len(y)), Fit(body)
    raw = RawScan(body.raised(height).vertices, body.faces, None, False, rgb, None, every, every)
    points = sample_person(raw, fit)
    near = cKDTree(raw.points).query(points.positions)[1]
    seen = np.select([~cloth, below], [Part.SKIN, Part.LOWER], Part.UPPER)[near]
    posterior = np.where(seen[:, None] == np.array(PARTS), 0.95, 0.05 / (len(PARTS) - 1))
    features = describe_points(points, fit)
    links = link_alike(link_points(points.positions, points.normals), points.lab)
    found = find_coat(points, features, posterior, links, body)
    above = above_waist_probability(features.place, body)
    outfits = rank_outfits(posterior, above, coat=found)
    read = condition_on_outfit(posterior, outfits[0].parts, above, found.over)
    return Worn(part[near], found, outfits[0].parts, np.array(PARTS)[read.argmax(axis=1)])


@pytest.fixture(scope="module")
def jacket() -> Worn:
    """Return a person in an open navy jacket over a cream top and grey trousers."""
    return wear(CREAM, GREY, NAVY, 0.05)


def test_an_open_jacket_is_an_outer_layer(jacket):
    """Broken where the edges of the front are not found, the back is the top's, or the front the jacket's."""
    assert jacket.coat.odds > 1.0
    assert jacket.outfit == (Part.UPPER, Part.LOWER, Part.OUTER)
    for part in (Part.OUTER, Part.UPPER):
        mine = jacket.part == part
        assert (jacket.label[mine] == part).mean() > 0.985


def test_one_cloth_in_front_is_no_outer_layer():
    """Broken where a shirt's folds make an outer layer, or a front without edges says nothing."""
    shirt = wear(NAVY, GREY, NAVY, 0.0)
    assert shirt.coat.odds == pytest.approx(-3.24, abs=0.2)  # one in ten, times a quarter, and a little for looseness
    assert shirt.outfit == (Part.UPPER, Part.LOWER)


def test_below_a_jacket_one_cloth_is_one_piece():
    """Broken where the jacket's hem, a ring around the trunk, makes two garments of a jumpsuit below it."""
    assert wear(GREY, GREY, NAVY, 0.05).outfit == (Part.ONE_PIECE, Part.OUTER)


def test_a_front_says_little_against_an_outer_layer_and_much_for_it():
    """Broken where a closed front rules a coat out, two edges make one certain, or a clear front says little."""
    scores = np.array([0.0, 16.0, 20.0, 25.0, 200.0])
    assert [open_evidence(score) for score in scores] == pytest.approx([-1.38, -1.04, 0.0, 2.21, 5.52], abs=0.1)


@pytest.mark.parametrize("height", [0.004, 0.03])
def test_looseness_is_the_cloths_height_over_the_waist(height):
    """Broken where another limb's cloth is measured, skin is, or a height in another unit."""
    body = builtin_body("builtin:female,pose=A")
    every, fit = np.arange(len(body.vertices)), Fit(body)
    arms = np.abs(body.rest_vertices[:, 0]) > 0.25
    raised = body.raised(np.where(arms, 0.05, height)).vertices
    points = sample_person(RawScan(raised, body.faces, None, False, None, None, every, every), fit)
    features = describe_points(points, fit)
    dressed = np.ones(len(points.positions), dtype=bool)
    assert measure_looseness(features, dressed, body) == pytest.approx(height, abs=0.0007)
    assert measure_looseness(features, ~dressed, body) is None


def test_loose_cloth_speaks_for_an_outer_layer_and_close_cloth_against_it():
    """Broken where the sign is turned round, nothing seen says something, or looseness alone makes it unsure."""
    offsets = (0.0, 0.004, 0.010, 0.0125, 0.015, 0.017, 0.5)
    found = [loose_evidence(offset) for offset in offsets]
    assert found == pytest.approx([-2.8, -2.8, -0.76, 0.0, 0.62, 1.05, 1.2], abs=0.05)
    assert loose_evidence(None) == 0.0
    prior, unsure = Coat().odds, MIN_OUTFIT_LOG_ODDS
    assert [prior, unsure] == pytest.approx([np.log(1 / 9), np.log(2)], abs=0.05)  # one person in ten, two to one
    assert prior + found[-1] < -unsure


def test_a_path_runs_along_what_gains():
    """Broken where a path takes rows that cost, jumps, or misses the end of an edge."""
    gain = np.full((30, 12), -1.0)
    column = 3 + np.arange(30) // 6
    gain[np.arange(5, 25), column[5:25]] = 1.0
    score, path = find_path(gain, 0.2)
    assert path[:5].tolist() == [-1] * 5
    assert path[25:].tolist() == [-1] * 5
    assert (path[5:25] == column[5:25]).all()
    assert score == pytest.approx(20 - 0.2 * (column[24] - column[5]))
    assert find_path(np.full((4, 3), -np.inf), 0.2)[1].tolist() == [-1] * 4


@pytest.mark.parametrize(("legs", "low", "high"), [(NAVY, 0.93, 1.0), (CREAM, 0.0, 0.03)])
def test_the_overlap_tells_one_cloth_from_two(legs, low, high):
    """Broken where sleeves, or what lies between chest and legs, are compared."""
    body = builtin_body("builtin:female,pose=A")
    y, x = body.rest_vertices[:, 1], np.abs(body.rest_vertices[:, 0])
    every, fit = np.arange(len(y)), Fit(body)
    rgb = np.where((y < body.rest_joints[1, 1])[:, None], legs, NAVY)
    rgb = np.where((x > 0.25)[:, None], CREAM, rgb)  # sleeves of another cloth
    rgb = (rgb + np.random.default_rng(0).normal(0.0, 0.01, rgb.shape)).clip(0.0, 1.0)
    points = sample_person(RawScan(body.vertices, body.faces, None, False, rgb, None, every, every), fit)
    place = describe_points(points, fit).place
    cloth = (place.rest[:, 1] > 0.15) & (place.rest[:, 1] < body.rest_joints[12, 1])
    assert low <= overlap_of_cloths(points.lab, place, body, cloth) <= high
    assert overlap_of_cloths(points.lab, place, body, cloth & (place.rest[:, 1] > 1.0)) is None


def test_two_cloths_speak_for_two_pieces():
    """Broken where the overlap counts the wrong way, outweighs all that shape shows, or is used without colours."""
    alike, unlike = (partial(WaistShown, coloured=10.0, overlap=overlap) for overlap in (0.9, 0.0))
    assert waist_evidence(alike(0.0)) < -1.5 < 1.5 < waist_evidence(unlike(0.0))
    assert 0.0 < waist_evidence(unlike(-20.0)) < 0.7  # a smooth waist between two cloths: who knows
    assert waist_evidence(alike(30.0)) > 0.5  # of one cloth, and a hem shows
    assert waist_evidence(unlike(30.0)) > waist_evidence(unlike(-5.0)) + 1.0
    assert waist_evidence(WaistShown(5.0, None, overlap=0.9)) == waist_evidence(WaistShown(5.0))


def test_two_cloths_are_two_pieces_where_they_meet_in_a_step():
    """Broken where a fold elsewhere makes a dress of two colours a top and a skirt, or a belt is where cloths meet."""
    seen = partial(WaistShown, 5.0, coloured=40.0, overlap=0.0)
    blocked, hemmed = (waist_evidence(seen(between=between)) for between in (-20.0, 0.0))
    assert blocked < 0.7 < 2.0 < hemmed
    assert waist_evidence(seen(between=-20.0, roughness=0.8)) > blocked + 1.0  # noise hides steps
    belted = partial(WaistShown, 1.0, coloured=42.0, overlap=0.7)
    assert waist_evidence(belted(between=0.0)) == waist_evidence(belted(between=-20.0))
