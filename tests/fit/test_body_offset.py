"""A body that is only estimated under its cloth, raised to where the cloth rests on it."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body import builtin_body
from garmentq.core.drape import DrapeSettings, WearerGeometry, drape_template
from garmentq.core.fit import FitScene, ShapeProblem, ShapeSettings, estimate_body_offset, is_estimated
from garmentq.core.pattern import load_template
from garmentq.core.simulate import Scene, Topology, equilibrium, get_fabric, soften


def test_cloth_on_a_body_guessed_too_thin_hangs_where_it_was_scanned() -> None:
    """Breaks if the body moves the wrong way, by nodes that do not touch, or not far enough: the top then hangs low."""
    wearer = WearerGeometry(builtin_body("builtin:female,height=1.70"))
    assert not is_estimated(wearer.body)
    pattern, fabric = load_template("tank"), soften(get_fabric("cotton_poplin"))
    worn = drape_template(pattern, wearer, settings=DrapeSettings(template_vertices=400))
    scanned = worn.at(equilibrium(Scene(Topology.from_garment(worn), fabric, wearer.grid), worn.nodes).nodes)
    problem = ShapeProblem.of(
        FitScene.of(scanned, pattern, Scene(Topology.from_garment(scanned), fabric, wearer.grid.shrunk(0.012))),
        ShapeSettings(),
    )

    def fall(drape: np.ndarray) -> float:
        return float((scanned.nodes - drape)[:, 1].mean())

    sunk = fall(problem.drape(pattern, scanned.nodes).nodes)
    raised = estimate_body_offset(problem)
    hung = equilibrium(Scene(Topology.from_garment(scanned), fabric, raised), scanned.nodes).nodes
    assert sunk > 5e-3 and abs(fall(hung)) < 0.3 * sunk
    # far from the cloth nothing is known, and nothing moves
    head = wearer.body.vertices[wearer.body.vertices[:, 1].argmax()][None]
    assert raised.distance(head) == pytest.approx(wearer.grid.shrunk(0.012).distance(head), abs=1e-4)
