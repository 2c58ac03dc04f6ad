"""What lies beyond a garment's border says whether the border is seen."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.people.openings import _BorderSides, _classify_opening
from garmentq.core.people.part import Part


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
    sides = _BorderSides(np.full(count, step), np.full(count, 27.0), np.full(count, int(beyond)), 0.17)
    found = _classify_opening("hem", Part.UPPER, sides)
    assert found.is_inferred == is_inferred
