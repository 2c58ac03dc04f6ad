"""Which steps bring pattern and cloth together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from garmentq.core.recover.case import Case
from garmentq.core.recover.fit.isometry import choose_isometry_settings
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.scan.contours.target import Target

FILE = Path("maker.json")


@pytest.mark.parametrize(
    ("category", "template", "lock", "newton"),
    [
        ("tshirt", FILE, "", True),
        ("tank", FILE, "", True),
        ("trousers", FILE, "", False),
        ("dress", FILE, "", False),
        ("trousers", None, "", True),
        ("tshirt", FILE, "panel:front", False),
        ("tshirt", None, "point:front/2", False),
    ],
)
def test_what_begins_far_off_slides(category: str, template: Path | None, lock: str, newton: bool) -> None:
    """Broken where a maker's top creeps, what is eased slides past its place, or a user's locked panel is reshaped."""
    nowhere = np.zeros((0, 3))
    target = Target(nowhere, nowhere.astype(int), nowhere, (), (), category)
    request = Request(Path("scan.ply"), template=template, settings=RecoverySettings(lock=lock))
    case = Case(request, scan=None, scan_target=target, wearer=None)
    steps = choose_isometry_settings(case)
    assert steps.newton == newton
    assert not steps.curves
