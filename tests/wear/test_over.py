"""One garment over another: the wearer raised to the one below, how they lie, and both at rest together."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body import builtin_body
from garmentq.core.clock import Clock
from garmentq.core.drape import WearerGeometry
from garmentq.core.mesh import self_intersections, vertex_normals
from garmentq.core.pattern import Garment, load_draped_template
from garmentq.core.simulate import get_fabric
from garmentq.core.wear import Worn, dress_over, judge_wear
from garmentq.core.wear.underneath import measure_layers, raise_over

SPEC = "builtin:female,height=1.70"


def wear(name: str, fabric: str) -> Worn:
    """Return a shipped garment as it hangs on the body that it was drafted for."""
    garment = load_draped_template(name)
    waist = garment.contour("waist")
    curve = None if waist is None else garment.nodes[waist.vertices]
    return Worn(garment, get_fabric(fabric), builtin_body(SPEC), curve, None, name, name)


def grow(garment: Garment, height: float) -> Garment:
    """Return a garment with every node moved out along its normal by a height [m]."""
    return garment.at(garment.nodes + height * vertex_normals(garment.nodes, garment.faces))


def test_depth_between_two_layers():
    """Broken where a layer that lies under another passes for one above it."""
    below = load_draped_template("skirt")
    assert set(measure_layers(below, grow(below, 3e-3)).values()) == {0.0}
    under = measure_layers(below, grow(below, -3e-3))
    assert under["layers.crossing_faces"] == 0.0
    assert under["layers.depth_mm"] == pytest.approx(3.0, rel=0.1)
    through = below.at(below.nodes + [0.02, 0.0, 0.0])
    assert measure_layers(below, through)["layers.crossing_faces"] > 20.0


def test_verdict_on_layers():
    """Broken where a garment that passes through the one below is delivered as sound."""
    metrics = {"drape.residual": 0.0, "body_penetration_mm": 0.0, "self_intersecting_faces": 0.0, "drape.at_rest": 1.0}
    assert "layers" not in [gate.name for gate in judge_wear(metrics)]
    names = ("layers.crossing_faces", "layers.depth_mm", "under.self_intersecting_faces", "under.body_penetration_mm")
    for bad in (None, *names):
        gates = judge_wear({**metrics, **{name: 2.0 if name == bad else 0.0 for name in names}})
        assert [gate.verdict for gate in gates if gate.name == "layers"] == ["pass" if bad is None else "fail"]


def test_the_raised_wearer_encloses_what_he_wears():
    """Broken where cloth that goes over another garment starts inside of it, or skin is raised where there is none."""
    worn = wear("trousers", "denim")
    wearer = WearerGeometry(worn.body)
    raised = raise_over(wearer, worn.garment)
    near = wearer.exposed.closest(worn.garment.nodes).distance < 0.05
    assert near.mean() > 0.5
    assert raised.exposed.contains(worn.garment.nodes[near]).mean() > 0.99
    above = worn.body.vertices[:, 1] > worn.garment.nodes[:, 1].max() + 0.15
    np.testing.assert_array_equal(raised.body.vertices[above], worn.body.vertices[above])


@pytest.mark.nightly
def test_a_shirt_over_trousers():
    """Broken where the shirt passes through the trousers, ends under them, or takes their cloth."""
    shirt, trousers = wear("tshirt", "cotton_poplin"), wear("trousers", "denim")
    dressed = dress_over(shirt, trousers, builtin_body(f"{SPEC},pose=A"), None, Clock())
    assert dressed.under is not None and dressed.under.fabric.name == "denim"
    assert [gate.name for gate in dressed.gates if gate.verdict == "fail"] == []
    below, above = dressed.under.garment, dressed.worn.garment
    faces = np.concatenate([below.faces, above.faces + len(below.nodes)])
    assert len(self_intersections(np.concatenate([below.nodes, above.nodes]), faces)) == 0
    hem = above.nodes[:, 1] < below.nodes[:, 1].max() - 0.05
    assert hem.sum() > 100
