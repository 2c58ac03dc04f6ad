"""How deep below its clothes a wearer is expected, and how that was measured."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.people.depth import HANGING, HELD, LEG, LOOSE, TIGHT, Excess, find_depth
from garmentq.core.people.features import FEATURE_LENGTH_SCALE, FEATURE_NAMES
from garmentq.core.people.limbs import BodyPlace, Limb
from garmentq.core.people.part import PARTS, Part
from garmentq.core.people.separate import to_point_weights
from garmentq.training.depth import measure_excess
from garmentq.training.describe import Described


def place(limb: Limb, station: np.ndarray, height: np.ndarray) -> BodyPlace:
    """Return places along a limb that only stations and heights are read of."""
    count = len(station)
    none = np.zeros((count, 3))
    return BodyPlace(
        foot=none, normal=none, offset=height, distance=height, rest=none, parts=none, weights=none,
        limb=np.full(count, limb), along=none, front=none, station=station,
    )  # fmt: skip


def surely(part: Part, count: int) -> np.ndarray:
    """Return the posterior of samples that are one part."""
    return np.tile(np.array(PARTS) == part, (count, 1)).astype(np.float64)


def test_a_loose_garment_hides_more_than_the_fit_shows() -> None:
    """Broken where the waist under a hanging shirt stays as thick as a fit below it has it, or skin is moved in."""
    station = np.linspace(0.25, 0.6, 200)
    depth, spread = find_depth(place(Limb.TRUNK, station, np.full(200, 0.02)), surely(Part.UPPER, 200))
    assert depth == pytest.approx(0.02 + np.interp(station, HANGING.stations, HANGING.mean))
    assert spread == pytest.approx(np.interp(station, HANGING.stations, HANGING.spread))
    for part in (Part.SKIN, Part.HAIR, Part.SHOES, Part.OTHER):
        assert np.isnan(find_depth(place(Limb.TRUNK, station, np.full(200, 0.02)), surely(part, 200))[0]).all()
    assert np.isnan(find_depth(place(Limb.NECK, station, np.full(200, 0.02)), surely(Part.UPPER, 200))[0]).all()


@pytest.mark.parametrize("height", [-0.004, 0.0, TIGHT])
def test_a_tight_garment_hides_nothing(height: float) -> None:
    """Broken where leggings make their wearer thin, or cloth inside the fit asks for a body outside of the cloth."""
    depth, _ = find_depth(place(Limb.LEFT_LEG, np.linspace(0, 0.8, 90), np.full(90, height)), surely(Part.LOWER, 90))
    assert depth == pytest.approx(max(height, 0.0))


def test_each_garment_is_as_loose_as_it_is() -> None:
    """Broken where a wide top makes the tight skirt below it loose, or its shoulders, where it rests, make it tight."""
    station = np.concatenate([np.linspace(0.0, 0.19, 300), np.linspace(0.21, 0.45, 200), np.linspace(0.5, 0.7, 200)])
    height = np.where(station < 0.2, 0.001, np.where(station < 0.46, 0.03, 0.001))
    posterior = np.where((station < 0.46)[:, None], surely(Part.UPPER, 700), surely(Part.LOWER, 700))
    hidden = find_depth(place(Limb.TRUNK, station, height), posterior)[0] - height
    assert hidden[300:500] == pytest.approx(np.interp(station[300:500], HANGING.stations, HANGING.mean))
    assert hidden[500:] == pytest.approx(0.0)


def test_what_the_waist_holds_lies_on_it() -> None:
    """Broken where a skirt's waistband is taken to hang off the wearer as far as a shirt does there."""
    at = place(Limb.TRUNK, np.full(80, 0.42), np.full(80, 0.02))
    skirt, shirt = (find_depth(at, surely(part, 80))[0] for part in (Part.LOWER, Part.UPPER))
    assert skirt == pytest.approx(0.02 + np.interp(0.42, HELD.stations, HELD.mean))
    assert (shirt > skirt + 0.008).all()


def test_half_as_loose_hides_half() -> None:
    """Broken where looseness is a step, which a millimetre of the fit's own error turns over."""
    middle = 0.5 * (TIGHT + LOOSE)
    depth, _ = find_depth(place(Limb.LEFT_LEG, np.full(60, 0.4), np.full(60, middle)), surely(Part.LOWER, 60))
    assert depth - middle == pytest.approx(0.5 * np.interp(0.4, LEG.stations, LEG.mean))


def test_rounding_makes_no_weight_negative() -> None:
    """Broken where probabilities that add up to a little more than 1 weigh a pair below zero: the fit then fails."""
    posterior = np.zeros((1, len(PARTS)))
    posterior[0, [PARTS.index(Part.UPPER), PARTS.index(Part.LOWER)]] = 0.5, 0.5 + 3e-16
    assert posterior.sum() > 1.0
    assert to_point_weights(posterior).cloth.max() <= 1.0


def test_an_excess_is_measured_as_it_was_drawn() -> None:
    """Broken where long limbs, or scans with many samples, outweigh the others, or tight garments thin it."""
    rng = np.random.default_rng(0)
    true = Excess((0.25, 0.45), (0.008, 0.016), (0.002, 0.004))
    scans = []
    for n in range(40):
        count = int(rng.integers(60, 900))
        station = rng.choice([0.25, 0.45], count) + rng.uniform(-0.05, 0.05, count)
        near = np.abs(station[:, None] - true.stations).argmin(axis=1)
        height = np.full(count, (0.0, 0.02)[n % 2])
        drawn = np.array(true.mean)[near] + np.array(true.spread)[near] * rng.normal(size=count)
        values = np.zeros((count, len(FEATURE_NAMES)))
        values[:, FEATURE_NAMES.index("offset")] = height / FEATURE_LENGTH_SCALE
        none = np.zeros((count, 3))
        scans.append(
            Described(
                values, none, none, np.full(count, Limb.TRUNK), station, none, none, np.full(count, Part.UPPER),
                height + drawn * (n % 2), np.zeros(count), np.zeros(0), {},
            )
        )  # fmt: skip
    found = measure_excess(scans, true, (Limb.TRUNK,))
    assert found.mean == pytest.approx(true.mean, abs=3e-4)
    assert found.spread == pytest.approx(true.spread, rel=0.1)
