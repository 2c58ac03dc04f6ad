"""Where a deformation begins: on the scan and at the drape, or at the drape only."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.core.case import GradedDrape
from garmentq.core.clock import Clock
from garmentq.core.fit import METHODS, methods
from garmentq.core.pattern import load_draped_template
from garmentq.core.segment import Target
from garmentq.core.settings import RecoverySettings


@pytest.mark.parametrize(
    ("preset", "is_laid", "count"), [("default", True, 2), ("default", False, 1), ("thesis", True, 1)]
)
@pytest.mark.parametrize("nearer", [0, 1])
def test_a_deformation_begins_on_the_scan_too(monkeypatch, preset: str, is_laid: bool, count: int, nearer: int) -> None:
    """Broken where it begins in the drape's folds only, the further result is taken, or the thesis is not followed."""
    worn = load_draped_template("skirt")
    assert worn is not None
    began = []

    def begin(garment, *rest, **settings):
        began.append(garment.nodes)
        off = 0.0 if len(began) == 1 + nearer else 0.01
        return SimpleNamespace(nodes=worn.nodes + [0.0, off, 0.0], warnings=(str(len(began)),))

    monkeypatch.setattr(methods, "deform", begin)
    monkeypatch.setattr(methods, "_fair", lambda case, drape, garment, nodes: (garment, ()))
    target = Target(worn.nodes, worn.faces, np.zeros_like(worn.nodes), worn.contours, (), "skirt")
    settings = RecoverySettings(preset=preset)
    case = SimpleNamespace(settings=settings, target=target, wearer=SimpleNamespace(exposed=None), fabric=None)
    laid = worn.nodes + [0.1, 0.0, 0.0] if is_laid else None
    fit = METHODS["deform"].fit(case, GradedDrape(worn, None, laid=laid), Clock())
    assert len(began) == count
    assert np.array_equal(began[-1], worn.nodes)
    assert fit.warnings == (str(1 + nearer) if count == 2 else "1",)
