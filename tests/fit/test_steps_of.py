"""Which steps bring pattern and cloth together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body import builtin_body
from garmentq.core.case import Case
from garmentq.core.drape import WearerGeometry
from garmentq.core.fit.isometry import steps_of
from garmentq.core.pattern import load_draped_template
from garmentq.core.recovery import Request
from garmentq.core.scan import Scan
from garmentq.core.segment import Target
from garmentq.core.settings import RecoverySettings
from garmentq.core.simulate import get_fabric

FILE = Path("maker.json")


@pytest.fixture(scope="module")
def wearer() -> WearerGeometry:
    """Return the built-in body."""
    return WearerGeometry(builtin_body("builtin:female"))


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
def test_what_begins_far_off_slides(wearer, category: str, template: Path | None, lock: str, newton: bool) -> None:
    """Broken where a maker's top creeps, what is eased slides past its place, or a user's locked panel is reshaped."""
    worn = load_draped_template("tshirt")
    assert worn is not None
    target = Target(worn.nodes, worn.faces, np.zeros_like(worn.nodes), worn.contours, (), category)
    request = Request(Path("scan.ply"), template=template, settings=RecoverySettings(lock=lock))
    scan = Scan(worn.nodes, worn.faces)
    case = Case(request, scan, wearer, target, "name", worn.pattern, get_fabric("cotton_poplin"))
    steps = steps_of(case)
    assert steps.newton == newton
    assert not steps.curves
