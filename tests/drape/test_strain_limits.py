"""Makers' base patterns that hang too low unless the stretch is taken out of them."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.templates import load_template
from garmentq.core.recover.drape.pattern_easing import find_flare, needs_easing


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0, 1.7])
def test_flare_is_the_share_of_a_ring(share: float) -> None:
    """Fails if a longer skirt of the same cut flared more, or a straight one at all."""
    for inner, outer in ((0.1, 0.4), (0.2, 1.1)):
        hem, waist = (2.0 * np.pi * share * radius for radius in (outer, inner))
        assert find_flare(hem, waist, np.pi * share * (outer**2 - inner**2)) == pytest.approx(share)
    assert find_flare(0.9, 0.9, 0.5) == 0.0


@pytest.mark.parametrize(
    ("name", "category", "eased"),
    [
        ("skirt", "skirt", True),
        ("skirt+skirt=half-circle", "skirt", True),
        ("skirt+skirt=full-circle", "skirt", False),
        ("trousers", "trousers", True),
        ("sleeved_dress", "dress", True),
        ("tshirt", "tshirt", False),
    ],
)
def test_what_could_hang_too_low_is_eased(name: str, category: str, eased: bool) -> None:
    """Fails if trousers hang with their crotch too low before they are graded, or a circle floats."""
    assert needs_easing(load_template(name), category) == eased
