"""Among the best starts of a registration, fits that are all one do not crowd out another."""

import numpy as np
from garmentq.core.body.competing_starts import find_distinct_fits
from garmentq.core.body.fit import FitState
from garmentq.core.body.template import load_template, rotations_of


def test_a_wearer_facing_the_other_way_is_another_fit() -> None:
    """Breaks if the finalists can be one fit several times over: under a long dress it faced the wrong way."""
    template = load_template()

    def entry(number, heading, shift=0.0):
        turned = np.zeros((24, 3))
        turned[0, 1] = heading
        state = FitState(np.zeros(4), rotations_of(turned), np.array([shift, 0.0, 0.0]))
        return (0.04 + 0.001 * number, number, state)

    best = [entry(0, 0.0), entry(1, 0.05), entry(2, 0.0, 0.02)]
    rest = [entry(3, 0.02), entry(4, np.pi), entry(5, np.pi - 0.05), entry(6, np.pi / 2)]
    assert [number for _, number, _ in find_distinct_fits(template, best, rest)] == [4, 6]
    assert find_distinct_fits(template, best, rest[:1]) == []
