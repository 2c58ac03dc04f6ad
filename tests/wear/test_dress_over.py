"""One garment over another: the wearer raised to the one below, how they lie, and both at rest together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.outcome import Outcome
from garmentq.core.cloth.statics import Drape
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.reuse.wear.dress_over import drape_together, dress_over
from garmentq.core.reuse.wear.outfit import dress_outfit
from garmentq.core.reuse.wear.raised_skin import is_covered, measure_layers, raise_skin_over
from garmentq.core.reuse.wear.verdicts import judge_wear
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.run.clock import Clock
from garmentq.core.run.hooks import SILENT_HOOKS

SPEC = "builtin:female,height=1.70"


def wear(name: str, fabric: str) -> WornGarment:
    """Return a shipped garment as it hangs on the body that it was drafted for."""
    garment = load_draped_template(name)
    waist = garment.contour("waist")
    curve = None if waist is None else garment.nodes[waist.vertices]
    return WornGarment(garment, get_fabric(fabric), builtin_body(SPEC), curve, None, name, name)


def grow(garment: Garment, height: float) -> Garment:
    """Return a garment with every node moved out along its normal by a height [m]."""
    return garment.at(garment.nodes + height * vertex_normals(garment.nodes, garment.faces))


def test_depth_between_two_layers():
    """Broken where a layer that lies under another passes for one above it."""
    below, skin = load_draped_template("skirt"), WearerGeometry(builtin_body(SPEC)).exposed
    assert set(measure_layers(below, grow(below, 3e-3), skin).values()) == {0.0}
    under = measure_layers(below, grow(below, -3e-3), skin)
    assert under["layers.crossing_faces"] == 0.0
    assert under["layers.depth_mm"] == pytest.approx(3.0, rel=0.1)
    through = below.at(below.nodes + [0.02, 0.0, 0.0])
    assert measure_layers(below, through, skin)["layers.crossing_faces"] > 20.0


def test_cloth_beyond_a_waistband_is_not_under_it():
    """Broken where a shirt that comes down to a waistband which stands off like a brim counts as lying under that."""
    garment, skin = load_draped_template("skirt"), WearerGeometry(builtin_body(SPEC)).exposed
    waist = garment.contour("waist").vertices
    centre, near = garment.nodes[waist].mean(axis=0), garment.nodes[:, 1] > garment.nodes[waist, 1].min() - 0.02
    brim = garment.nodes.copy()
    brim[near] += 0.5 * (brim[near] - centre) * [1.0, 0.0, 1.0]
    point = garment.nodes[waist[:1]] * 1.0 + [0.0, 0.04, 0.0]
    assert not is_covered(point, skin, garment.at(brim)).any()
    hips = garment.nodes[garment.nodes[:, 1] < garment.nodes[waist, 1].min() - 0.05]
    close = hips[skin.closest(hips).distance < 0.03]
    inner = close - 2e-3 * skin.measure(close)[1]
    assert len(close) > 50 and is_covered(inner, skin, garment).mean() > 0.9


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
    raised = raise_skin_over(wearer, worn.garment)
    near = wearer.exposed.closest(worn.garment.nodes).distance < 0.05
    assert near.mean() > 0.5
    assert raised.exposed.contains(worn.garment.nodes[near]).mean() > 0.99
    above = worn.body.vertices[:, 1] > worn.garment.nodes[:, 1].max() + 0.15
    np.testing.assert_array_equal(raised.body.vertices[above], worn.body.vertices[above])


def test_waists_are_held_where_they_lie(monkeypatch):
    """Broken where waists that were cleared of the skin are pushed back into the layers over them, leg for leg."""
    seen = []

    def keep(scene, nodes, hooks):
        seen.append((scene, nodes))
        return Drape(nodes, 0.0, 1, 0.0, Outcome.CONVERGED, nodes)

    monkeypatch.setattr("garmentq.core.reuse.wear.dress_over.equilibrium", keep)
    lower, upper = wear("skirt", "denim"), wear("tshirt", "cotton_poplin")
    moved = replace(lower, waist=lower.waist + [0.0, 0.01, 0.0])
    garments, _ = drape_together((moved, upper), WearerGeometry(lower.body), SILENT_HOOKS)
    ((scene, nodes),) = seen
    assert len(scene.pins.nodes) == len(lower.waist) and len(garments) == 2
    np.testing.assert_array_equal(scene.pins.points, nodes[scene.pins.nodes])
    order = [k * len(lower.garment.nodes) for k in (0, 1)]
    np.testing.assert_array_equal(nodes[order[1] :], upper.garment.nodes)
    assert scene.pins.nodes.max() < order[1]


def test_an_outfit_is_judged_garment_by_garment(monkeypatch):
    """Broken where a garment is judged by another's numbers, or what lies under another one passes unseen."""
    skirt = wear("skirt", "denim")
    inner = replace(skirt, garment=grow(skirt.garment, -1.5e-3))

    def stay(garments, wearer, hooks):
        nodes = np.concatenate([one.garment.nodes for one in garments])
        return tuple(garments), Drape(nodes, 0.2, 4, 0.0, Outcome.ITERATIONS, nodes)

    monkeypatch.setattr(
        "garmentq.core.reuse.wear.outfit.drape_in_order", lambda garments, wearer, hooks: tuple(garments)
    )
    monkeypatch.setattr("garmentq.core.reuse.wear.outfit.drape_together", stay)
    right = dress_outfit({"lower": inner, "upper": skirt}, skirt.body, Clock())
    wrong = dress_outfit({"upper": skirt, "lower": inner}, skirt.body, Clock())
    verdicts = [{gate.name: gate.verdict for gate in one.report.gates} for one in (right, wrong)]
    assert [one["at_rest"] for one in verdicts] == ["fail", "fail"]
    assert (verdicts[0]["upper.layers"], verdicts[1]["lower.layers"]) == ("pass", "fail")
    assert "lower.layers" not in verdicts[0] and list(right.garments) == ["lower", "upper"]
    assert wrong.report.metrics["layers.depth_mm"] == pytest.approx(1.5, rel=0.1)
    assert (
        right.report.metrics["vertices"]
        == 2.0 * len(skirt.garment.nodes)
        == 2.0 * right.report.metrics["upper.vertices"]
    )
    assert right.report.metrics["drape.residual"] == 0.2 and "upper.drape.residual" not in right.report.metrics


@pytest.mark.nightly
def test_a_shirt_over_trousers():
    """Broken where the shirt passes through the trousers, ends under them, or takes their cloth."""
    shirt, trousers = wear("tshirt", "cotton_poplin"), wear("trousers", "denim")
    dressed = dress_over(shirt, trousers, builtin_body(f"{SPEC},pose=A"), None, Clock())
    assert dressed.inner is not None and dressed.inner.fabric.name == "denim"
    assert [gate.name for gate in dressed.report.gates if gate.verdict == "fail"] == []
    below, above = dressed.inner.garment, dressed.worn.garment
    faces = np.concatenate([below.faces, above.faces + len(below.nodes)])
    assert len(self_intersections(np.concatenate([below.nodes, above.nodes]), faces)) == 0
    hem = above.nodes[:, 1] < below.nodes[:, 1].max() - 0.05
    assert hem.sum() > 100
    outfit = dress_outfit({"lower": trousers, "upper": shirt}, builtin_body(f"{SPEC},pose=A"), Clock())
    assert [gate.name for gate in outfit.report.gates if gate.verdict == "fail"] == []
    np.testing.assert_array_equal(outfit.garments["upper"].worn.garment.nodes, above.nodes)
