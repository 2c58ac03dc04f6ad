"""What lies beyond a garment's border says whether the border is seen."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.curves import Curve
from garmentq.core.people.openings import (
    BorderSides,
    Surroundings,
    _classify_opening,
    find_openings,
    is_covered,
    measure_interval,
)
from garmentq.core.people.part import Part
from garmentq.core.scan.contours.target import Contour
from garmentq.core.scan.scan import Scan
from scipy.stats import norm


@pytest.mark.parametrize(
    ("beyond", "step", "is_inferred"),
    [
        (Part.SKIN, 0.005, False),
        (Part.OTHER, -0.004, True),
        (Part.OTHER, 0.008, False),
        (Part.HAIR, -0.004, True),
        (Part.HAIR, 0.008, True),
    ],
)
def test_what_a_garment_stands_out_over_does_not_cover_it(beyond, step, is_inferred):
    """Breaks where a hem is hidden by its own inside, of another colour from below, or a neck is seen below hair."""
    count = 100
    sides = BorderSides(np.full(count, step), np.full(count, 27.0), np.full(count, int(beyond)), 0.17)
    found = _classify_opening("hem", sides, is_covered(Part.UPPER, sides))
    assert found.is_inferred == is_inferred == is_covered(Part.UPPER, sides)


def test_a_waist_below_a_top_lies_within_what_base_patterns_miss_it_by():
    """Broken where a hidden end is said to be as sure as a seen one, or one of which nothing is known has a figure."""
    turn = np.arange(0.0, 2.0 * np.pi, 0.05)
    heights = np.arange(-0.1, 0.1, 0.01)
    wall = np.concatenate(
        [np.column_stack([0.2 * np.cos(turn), np.full(len(turn), h), 0.2 * np.sin(turn)]) for h in heights]
    )
    rows, columns = len(heights), len(turn)
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b = index[:-1], np.roll(index, -1, axis=1)[:-1]
    c, d = index[1:], np.roll(index, -1, axis=1)[1:]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, c, b), (b, c, d))])
    label = np.where(wall[:, 1] < -0.005, int(Part.LOWER), int(Part.UPPER))
    below = faces[(label[faces] == Part.LOWER).all(axis=1)]
    garment = Scan(wall[: below.max() + 1], below)
    rim = index[np.flatnonzero(heights < -0.005)[-1]]
    height = np.where(label == Part.UPPER, 0.01, 0.0)
    around = Surroundings(wall, label, None, height, 0.2, np.full(len(wall), 1e-4), np.full(len(wall), 0.1))
    contours = tuple(Contour(name, rim, 1.2, ()) for name in ("waist", "hem"))
    waist, hem = find_openings(garment, contours, Part.LOWER, around)
    assert waist.is_inferred and waist.interval == pytest.approx(0.0592, abs=1e-4)
    assert hem.is_inferred and hem.interval is None


def test_the_doubt_beside_a_border_is_its_interval():
    """Broken where the interval of a normally distributed border is not 1.645 deviations, or counts other doubts."""
    deviation, step = 0.01, 0.0025
    turn = 2.0 * np.pi * np.arange(160) / 160
    ring = np.column_stack([0.2 * np.cos(turn), np.zeros(160), 0.2 * np.sin(turn)])
    heights = step * (np.arange(-40, 40) + 0.5)
    points = np.concatenate([ring + [0.0, height, 0.0] for height in heights])
    wrong = np.repeat(norm.sf(np.abs(heights) / deviation), 160)
    label = np.repeat(np.where(heights > 0.0, int(Part.UPPER), int(Part.SKIN)), 160)
    area = step * np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum() / 160
    around = Surroundings(points, label, None, np.zeros(len(points)), 1.0, np.full(len(points), area), 0.1 + wrong)
    found = measure_interval(around, Curve(ring), (Part.UPPER, Part.SKIN))
    assert found == pytest.approx(1.645 * deviation, rel=0.02)
    assert measure_interval(around, Curve(ring), (Part.UPPER, Part.LOWER)) == pytest.approx(0.5 * found, rel=0.02)
