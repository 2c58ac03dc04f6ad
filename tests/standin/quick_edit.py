"""A drape of an edited pattern that takes no time."""

from __future__ import annotations

import pytest
from garmentq.core.cloth.outcome import Outcome
from garmentq.core.cloth.statics import Drape


def drape_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let draping take no time: the garment stays where it is."""

    def drape(garment, wearer, fabric, target, **_):
        return garment, Drape(garment.nodes, 0.1, 3, 1.0, Outcome.CONVERGED, garment.nodes)

    monkeypatch.setattr("garmentq.core.reuse.edit.redraping.drape_graded", drape)
    monkeypatch.setattr(
        "garmentq.core.reuse.edit.redraping.separate_layers", lambda worn, *given: (worn.garment.nodes, given[1])
    )
