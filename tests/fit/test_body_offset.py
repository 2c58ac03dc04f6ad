"""A body that is only estimated under its cloth, raised to where the cloth rests on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.locking import reduce_membrane_stiffness
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.templates import load_template
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.fit import body_offset
from garmentq.core.recover.fit.body_offset import (
    OffsetSettings,
    _average_nearby,
    estimate_body_offset,
    is_body_estimated,
)
from garmentq.core.recover.fit.scene import FitScene
from garmentq.core.recover.fit.settings import ShapeSettings
from garmentq.core.recover.fit.shape import ShapeProblem
from wearers import find_wearer


@dataclass(frozen=True)
class Hung:
    """A top that was scanned on its wearer, and the problem of fitting it on a body guessed 12 mm too thin."""

    wearer: WearerGeometry
    scanned: Garment
    thin: WearerGeometry
    fabric: Fabric
    problem: ShapeProblem


@pytest.fixture(scope="module")
def hung() -> Hung:
    """Hang a top."""
    wearer = find_wearer()
    pattern, fabric = load_template("tank"), reduce_membrane_stiffness(get_fabric("cotton_poplin"))
    worn = drape_template(pattern, wearer, settings=DrapeSettings(template_vertices=400))
    scanned = worn.at(equilibrium(Scene(Topology.from_garment(worn), fabric, wearer.grid), worn.nodes).nodes)
    thin = wearer.raised(np.full(len(wearer.body.vertices), -0.012))
    scene = Scene(Topology.from_garment(scanned), fabric, thin.grid)
    return Hung(wearer, scanned, thin, fabric, ShapeProblem.of(FitScene.of(scanned, pattern, scene), ShapeSettings()))


def test_cloth_on_a_body_guessed_too_thin_hangs_where_it_was_scanned(hung: Hung) -> None:
    """Breaks if the body moves the wrong way, by nodes that do not touch, or not far enough: the top then hangs low."""
    wearer, scanned, thin, problem = hung.wearer, hung.scanned, hung.thin, hung.problem
    assert not is_body_estimated(wearer.body)

    def fall(drape: np.ndarray) -> float:
        return float((scanned.nodes - drape)[:, 1].mean())

    sunk = fall(problem.drape(scanned.pattern, scanned.nodes).nodes)
    heights = estimate_body_offset(problem, thin)
    raised = thin.raised(heights)
    rested = equilibrium(Scene(Topology.from_garment(scanned), hung.fabric, raised.grid), scanned.nodes).nodes
    assert sunk > 5e-3 and abs(fall(rested)) < 0.3 * sunk
    # far from the cloth nothing is known, and nothing moves; nowhere does the body stand out of the cloth
    assert abs(heights[wearer.body.vertices[:, 1].argmax()]) < 1e-4
    assert raised.exposed.measure(scanned.nodes)[0].min() > -1e-3


def test_a_body_still_too_low_is_raised_again(hung: Hung, monkeypatch: pytest.MonkeyPatch) -> None:
    """Breaks if rounds end before the cloth rests where it was scanned: one narrow round leaves 12 mm half done."""
    problem, thin = hung.problem, hung.thin
    missing = []

    def spread(vertices: np.ndarray, points: np.ndarray, out: np.ndarray, areas: np.ndarray, *rest: object) -> object:
        missing.append(float(np.sqrt((areas * out**2).sum() / areas.sum())))
        return _average_nearby(vertices, points, out, areas, *rest)

    settings = OffsetSettings(kernel_stds=(0.03,))
    monkeypatch.setattr(body_offset, "_average_nearby", spread)
    estimate_body_offset(problem, thin, settings=settings)
    assert 2 < len(missing) < settings.iterations
    assert min(missing[:-1]) > settings.tolerance >= missing[-1]


def test_a_raised_body_is_one_body() -> None:
    """Breaks where the grid, the exposed skin or the T-pose of a raised wearer is that of the body below."""
    wearer = find_wearer()
    raised = wearer.raised(np.full(len(wearer.body.vertices), 0.004)).raised(np.full(len(wearer.body.vertices), 0.006))
    vertices, faces = raised.body.vertices, raised.body.faces
    waist = np.abs(vertices[faces].mean(axis=1)[:, 1] - 1.05) < 0.1  # no limb is near
    middles = vertices[faces[waist]].mean(axis=1)
    assert np.abs(raised.grid.measure(middles)[0]).max() < 2e-3
    assert np.abs(raised.exposed.measure(middles)[0]).max() < 1e-9
    assert wearer.exposed.measure(middles)[0].mean() == pytest.approx(0.01, rel=0.05)
    assert np.array_equal(raised.offset, np.full(len(vertices), 0.01))
    assert np.allclose(raised.rest.vertices, vertices)  # this body is in its T-pose
