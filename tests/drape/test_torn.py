"""A pattern that is caught while it is dressed is dressed again."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.drape import stage
from garmentq.core.recover.drape.stage import redrape
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.scan.contours.target import Target


@pytest.fixture(scope="module")
def worn() -> Garment:
    """Return a tank top as it hangs on the built-in body."""
    found = load_draped_template("tank")
    assert found is not None
    return found


def catch(garment: Garment) -> Garment:
    """Return the garment with a hundredth of its nodes held back by a hand's width."""
    nodes = garment.nodes.copy()
    nodes[:: len(nodes) // 15] += [0.0, -0.1, 0.0]
    return replace(garment, nodes=nodes)


@pytest.mark.parametrize("caught", [{1500}, {3000}, {1500, 3000}, set()])
def test_what_is_caught_is_dressed_again(worn, monkeypatch, caught):
    """Broken where cloth caught at rest is taken, a sound one is dressed twice, or a worse second try counts."""
    tried = []

    def dress(pattern, wearer, target, *, carry, settings, hooks):
        tried.append(settings.template_vertices)
        return catch(worn) if settings.template_vertices in caught else worn

    monkeypatch.setattr(stage, "drape_template", dress)
    monkeypatch.setattr(stage, "drape_graded", lambda garment, *given, **named: (garment, SimpleNamespace()))
    body = builtin_body("builtin:female")
    target = Target(worn.nodes, worn.faces, np.zeros_like(worn.nodes), worn.contours, (), "tank")
    draped, _ = redrape(worn, WearerGeometry(body), get_fabric("cotton_poplin"), target)
    assert tried == ([1500, 3000] if 1500 in caught else [1500])
    assert stage.measure_stretch(worn) < stage.MAX_DRESSED_STRETCH
    assert (stage.measure_stretch(draped) < stage.MAX_DRESSED_STRETCH) == (caught != {1500, 3000})
