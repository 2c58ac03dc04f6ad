"""Colours of simulated scans, and what the ring at the waist is worth by them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.template import load_template
from garmentq.core.people.part import Part
from garmentq.core.people.rules import BELTED, HIDDEN, WaistModel, WaistShown, waist_evidence
from garmentq.training.colours import WITHOUT, draw_cloths, paint
from garmentq.training.shards import Shard
from garmentq.training.waists import WaistRow, fit_model


@pytest.fixture(scope="module")
def shard() -> Shard:
    """Return the built-in body as a scan: a top above the hips, trousers below, skin at head, arms and feet."""
    template = load_template()
    points = template.vertices
    height = points[:, 1]
    label = np.full(len(points), int(Part.SKIN), np.uint8)
    trunk = np.abs(points[:, 0]) < 0.2
    low, high = np.quantile(height[trunk], (0.1, 0.9))
    middle = template.joints[0, 1]
    label[trunk & (height > middle) & (height < high)] = Part.UPPER
    label[trunk & (height <= middle) & (height > low)] = Part.LOWER
    normals = points - points.mean(axis=0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    nothing = np.zeros(len(points))
    surface = np.select([label == Part.UPPER, label == Part.LOWER], [1, 2], 0).astype(np.uint8)
    materials = [(int(Part.SKIN), "skin"), (int(Part.UPPER), "cloth"), (int(Part.LOWER), "cloth")]
    about = {"seed": 0, "scan": 0, "materials": materials, "scanner": {"kind": "fused"}}
    return Shard(points, normals, np.zeros((0, 3), int), label, surface, nothing, nothing, points, {}, about)


def test_a_seed_wears_the_same_colours_under_another_light(shard: Shard):
    """Broken where a set cannot be made again, or two scans of a person show other clothes."""
    first, again = paint(shard, always=True), paint(shard, always=True)
    assert first is not None and again is not None
    np.testing.assert_array_equal(first, again)
    assert first.min() >= 0.0 and first.max() <= 1.0
    other = paint(replace(shard, about=shard.about | {"scan": 1}), always=True)
    stranger = paint(replace(shard, about=shard.about | {"seed": 1}), always=True)

    def far(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.mean([np.abs(a[shard.label == k].mean(axis=0) - b[shard.label == k].mean(axis=0)).max()
                              for k in (Part.UPPER, Part.LOWER)]))  # fmt: skip

    assert 0.0 < far(first, other) < 0.5 * far(first, stranger)


def test_some_scanners_give_no_colours(shard: Shard):
    """Broken where all scans or none have colours: the rules must be calibrated for both."""
    few = replace(
        shard,
        points=shard.points[::50],
        normals=shard.normals[::50],
        label=shard.label[::50],
        surface=shard.surface[::50],
    )
    have = [paint(replace(few, about=shard.about | {"seed": seed})) is not None for seed in range(40)]
    assert 1.0 - 2.0 * WITHOUT < np.mean(have) < 1.0


def test_what_is_in_the_skins_colour_is_near_it():
    """Broken where underwear or hair is drawn as cloth, or a garment never has the skin's colour."""
    materials = [
        (int(Part.SKIN), "skin"),
        (int(Part.HAIR), "hair"),
        (int(Part.SKIN), "cloth"),
        (int(Part.UPPER), "cloth"),
    ]
    rest, far = np.zeros((200, 3)), []
    for seed in range(40):
        about = {"seed": seed, "scan": 0, "materials": materials}
        cloths = draw_cloths(about, np.random.default_rng(seed))
        skin = cloths[0](rest).mean(axis=0)
        far.append([np.abs(cloths[number](rest).mean(axis=0) - skin).max() for number in (1, 2, 3)])
    assert 0.0 < np.mean(np.array(far)[:, 2] < 0.1) < 0.4


def test_an_image_paints_the_back_as_the_front(shard: Shard):
    """Broken where what an image does not show has colours of its own."""
    about = shard.about | {"scanner": {"kind": "image"}}
    painted = paint(replace(shard, about=about), always=True)
    behind = shard.normals[:, 2] <= 0.0
    front = {tuple(row) for row in painted[~behind]}
    assert all(tuple(row) in front for row in painted[behind])


def test_what_a_waist_shows_is_bounded():
    """Broken where a ring that is missing proves one piece, or a belt two: waists may be hidden."""
    model = WaistModel()
    none, even, clear = (waist_evidence(WaistShown(score)) for score in (-200.0, model.by_shape[0], 200.0))
    assert none == pytest.approx(np.log(HIDDEN / (1.0 - BELTED)), abs=1e-6)
    assert even == pytest.approx(0.0, abs=1e-12)
    assert clear == pytest.approx(np.log((1.0 - HIDDEN) / BELTED), abs=1e-6)
    scores = [waist_evidence(WaistShown(score, 0.0)) for score in np.linspace(-40, 60, 50)]
    assert (np.diff(scores) > 0).all()


def test_noise_hides_waists_and_makes_none():
    """Broken where a rough scan without a ring speaks for one piece as a smooth one does, or less for a clear ring."""
    odds = [waist_evidence(WaistShown(-10.0, roughness=roughness)) for roughness in (0.05, 0.3, 0.6)]
    assert odds[0] < odds[1] - 0.5 < odds[2] - 1.0 < 0.0
    assert waist_evidence(WaistShown(40.0, roughness=0.3)) == pytest.approx(waist_evidence(WaistShown(40.0)), abs=0.2)


def test_one_cloth_above_and_below_is_told_by_its_shape():
    """Broken where a tracksuit is one piece because no colour changes, or a change of colours alone is not believed."""
    assert waist_evidence(WaistShown(40.0, -10.0)) > 0.5
    assert waist_evidence(WaistShown(-5.0, 60.0)) > 1.8
    assert waist_evidence(WaistShown(-5.0, -15.0)) < waist_evidence(WaistShown(-5.0)) < 0.0
    assert waist_evidence(WaistShown(-5.0, 10.0, overlap=0.9)) < -2.0


def test_the_constants_of_waists_are_found_again():
    """Broken where the fit does not put the centres between the kinds, or hidden waists leave it as it was."""
    rng = np.random.default_rng(0)
    one, two, flat = rng.normal(-4.0, 4.0, 20), rng.normal(30.0, 8.0, 16), rng.normal(-4.0, 4.0, 4)

    def fit(pairs: np.ndarray) -> WaistModel:
        kinds = ((True, one), (False, pairs))
        return fit_model(
            [WaistRow("", is_one, False, s, 3 * s, s - 15.0, 0.0) for is_one, group in kinds for s in group]
        )

    clear, doubtful = fit(two), fit(np.append(two, flat))
    assert 2.0 < clear.by_shape[0] < 22.0
    assert 6.0 < clear.with_colours[0] < 60.0
    assert doubtful.hidden > 1.5 * clear.hidden
