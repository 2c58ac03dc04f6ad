"""Verdicts: which number leads to which, and what the user is told."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.cloth.fabric import FabricEstimate
from garmentq.core.judge.estimates import summarise_estimates
from garmentq.core.judge.gates import GATE_RULES, Product, evaluate_gates, product_of
from garmentq.core.run.verdict import Verdict, worst_verdict

GOOD = {
    "faces": 8000.0,
    "surface_rms_mm.s2t": 1.0,
    "surface_rms_mm.t2s": 1.5,
    "seam_mismatch_mm": 0.05,
    "body_penetration_mm": 0.0,
    "pinched_mm": 2.0,
    "flipped_faces": 4.0,
    "self_intersecting_faces": 10.0,
    "graded.self_intersecting_faces": 10.0,
    "drape.residual": 0.001,
    "drape.at_rest": 1.0,
    "body.undeclared_mm": 0.0,
    "sim.surface_rms_mm.s2t": 3.0,
    "sim.surface_rms_mm.t2s": 4.0,
    "wear.rest_gap_mm": 4.0,
    "wear.layers": 1.02,
    "wear.sides_mm": 4.0,
    "wear.waist_by_hem": 0.7,
    "hidden_percent": 0.0,
    "inferred_ends": 0.0,
    "pattern.corner_deg": 0.4,
    "pattern.pointed_corner_deg": 20.0,
    "pattern.beyond_human": 0.8,
    "shape.neck_corner_deg": 12.0,
    "shape.collar_cm2": 40.0,
    "cut.collar_probability": 0.97,
    "shape.edge_corner_deg": 8.0,
    "shape.neck_mm": 9.0,
    "shape.hem_mm": 11.0,
    "redrape.surface_rms_mm.s2t": 8.0,
    "redrape.surface_rms_mm.t2s": 8.0,
    "redrape.stretch_p999": 1.1,
    "redrape.self_intersecting_faces": 4.0,
}


def verdicts(**changes: float | None) -> dict[str, str]:
    """Judge good metrics with some of them changed; `__` stands for a dot."""
    metrics = GOOD | {name.replace("__", "."): value for name, value in changes.items()}
    return {gate.name: gate.verdict for gate in evaluate_gates(metrics)}


def test_a_good_result_passes_every_gate() -> None:
    """Fails if a gate were missing or judged the wrong way round."""
    found = verdicts()
    assert list(found) == [rule.name for rule in GATE_RULES if rule.name != "redrape"]
    assert set(found.values()) == {"pass"}


LIMITS = (
    ("surface_fit_s2t", "surface_rms_mm.s2t", 2.5, 10.0),
    ("surface_fit_t2s", "surface_rms_mm.t2s", 4.0, 15.0),
    ("collar", "shape.collar_cm2", 100.0, 200.0),
    ("hidden", "hidden_percent", 10.0, 50.0),
    ("ends", "inferred_ends", 0.5, 4.0),
    ("sides", "wear.sides_mm", 40.0, 150.0),
    ("seams", "seam_mismatch_mm", 0.5, 3.0),
    ("fairness", "pattern.corner_deg", 5.0, 30.0),
    ("pointed", "pattern.pointed_corner_deg", 60.0, 80.0),
    ("neckline", "shape.neck_corner_deg", 30.0, 60.0),
    ("edge_corners", "shape.edge_corner_deg", 25.0, 60.0),
    ("contour_shape", "shape.hem_mm", 40.0, 100.0),
    ("plausible", "pattern.beyond_human", 1.0, 1.5),
    ("penetration", "body_penetration_mm", 1.0, 5.0),
    ("undeclared", "body.undeclared_mm", 9.0, 50.0),
    ("pinched", "pinched_mm", 5.0, 25.0),
    ("flips", "flipped_faces", 40.0, 240.0),
    ("self_intersections", "self_intersecting_faces", 50.0, 250.0),
    ("simulation_fit", "sim.surface_rms_mm.s2t", 15.0, 30.0),
    ("simulation_fit", "sim.surface_rms_mm.t2s", 15.0, 30.0),
    ("rest", "wear.rest_gap_mm", 25.0, 50.0),
    ("layers", "wear.layers", 1.3, 1.6),
    ("upright", "wear.waist_by_hem", 1.0, 1.25),
    ("redrape_fit", "redrape.surface_rms_mm.s2t", 20.0, 40.0),
    ("redrape_fit", "redrape.surface_rms_mm.t2s", 20.0, 40.0),
    ("redrape_stretch", "redrape.stretch_p999", 1.3, 2.0),
    ("redrape_intersections", "redrape.self_intersecting_faces", 40.0, 240.0),
    ("drape_residual", "drape.residual", 1.0, 100.0),
)
"""Gate, metric, and the values of the metric from which on it is doubtful and fails; numbers of faces are of 8000, and
the graded drape has 10 of those that intersect."""


@pytest.mark.parametrize(("gate", "metric", "warns", "fails"), LIMITS)
def test_each_gate_warns_then_fails(gate: str, metric: str, warns: float, fails: float) -> None:
    """Fails if a gate read another metric, warned where it should fail, or a limit moved by 2 per cent."""
    name = metric.replace(".", "__")
    for value, verdict in ((0.98 * warns, "pass"), (1.02 * warns, "doubtful"), (0.98 * fails, "doubtful")):
        assert verdicts(**{name: value}) == verdicts() | {gate: verdict}
    assert verdicts(**{name: 1.02 * fails}) == verdicts() | {gate: "fail"}


def test_every_gate_is_tried_at_its_limits() -> None:
    """Fails if a gate were added whose limits nothing tries; what is counted or is not there is tried below."""
    assert {gate for gate, *_ in LIMITS} == {rule.name for rule in GATE_RULES} - {"at_rest", "redrape", "neck_finish"}


def test_a_collar_that_is_not_likely_is_doubtful() -> None:
    """Fails if the probability were read as that of another collar, or an unlikely one failed for that alone."""
    for probability, verdict in ((0.86, "pass"), (0.84, "doubtful"), (0.0, "doubtful")):
        assert verdicts(cut__collar_probability=probability)["neck_finish"] == verdict


def test_a_result_without_its_redrape_is_doubtful() -> None:
    """Fails if a pattern that was not sewn again passed, or failed for that alone."""
    assert verdicts(redrape_missing=1.0)["redrape"] == "doubtful"


def test_a_pattern_dressed_anew_may_be_as_stretched_as_the_scan() -> None:
    """Fails if cloth that the scan shows stretched counted against the pattern, or a torn mesh excused another one."""
    assert verdicts(redrape__stretch_p999=1.34, stretch_p999=1.28)["redrape_stretch"] == "pass"
    assert verdicts(redrape__stretch_p999=1.34, stretch_p999=1.27)["redrape_stretch"] == "doubtful"
    assert verdicts(redrape__stretch_p999=1.57, stretch_p999=2.60)["redrape_stretch"] == "pass"
    assert verdicts(redrape__stretch_p999=1.58, stretch_p999=2.60)["redrape_stretch"] == "doubtful"
    assert verdicts(redrape__stretch_p999=2.50, stretch_p999=2.60)["redrape_stretch"] == "fail"


def test_what_was_not_measured_is_not_judged() -> None:
    """Fails if a missing number passed for a good one."""
    assert "penetration" not in verdicts(body_penetration_mm=None)
    assert "pinched" not in verdicts(pinched_mm=None)
    assert evaluate_gates({}) == ()


def test_the_drape_that_counts_is_judged() -> None:
    """Fails if an intermediate drape in unrest spoilt a result whose last drape rests, or the other way round."""
    assert verdicts(drape__residual=500.0, redrape__residual=0.5)["drape_residual"] == "pass"
    assert verdicts(redrape__residual=500.0)["drape_residual"] == "fail"


def test_every_drape_that_is_delivered_is_judged() -> None:
    """Fails if a simulation mesh or a re-draped one that is not at rest passed, or an older result got a verdict."""
    assert verdicts(drape__at_rest=0.0, sim__at_rest=1.0, redrape__at_rest=1.0)["at_rest"] == "pass"
    assert verdicts(sim__at_rest=0.0, redrape__at_rest=1.0)["at_rest"] == "doubtful"
    assert verdicts(sim__at_rest=1.0, redrape__at_rest=0.0)["at_rest"] == "doubtful"
    assert verdicts(drape__at_rest=0.0)["at_rest"] == "doubtful"
    assert verdicts(sim__residual=500.0, redrape__residual=0.5)["drape_residual"] == "fail"
    assert verdicts(sim__residual=0.5, redrape__residual=np.nan)["drape_residual"] == "fail"
    assert "at_rest" not in verdicts(drape__at_rest=None)


def test_every_gate_judges_one_product() -> None:
    """Fails if an unsettled drape counted against the detail mesh, or the seams against the drape."""
    products = {rule.name: product_of(rule.name) for rule in GATE_RULES}
    assert set(products.values()) == set(Product)
    assert products["drape_residual"] == products["simulation_fit"] == "drape"
    assert products["seams"] == "pattern"
    assert products["surface_fit_s2t"] == products["penetration"] == "detail"


def test_what_is_known_are_flat_numbers() -> None:
    """Fails if a value that was not found were given as one, or a deviation were in metres."""
    estimates = (
        FabricEstimate("k", 2e-5, 0.3, 1.9, True, "found"),
        FabricEstimate("H00", 300.0, 0.7, 0.7, False, "left open"),
    )
    found = summarise_estimates(estimates, np.array([[0.001, 0.003]]))
    assert found == {
        "fabric.k": 2e-5, "fabric.k.std": 0.3, "fabric.k.identifiable": 1.0,
        "fabric.H00": None, "fabric.H00.std": 0.7, "fabric.H00.identifiable": 0.0,
        "pattern.point_std_mm.mean": pytest.approx(2.0), "pattern.point_std_mm.max": pytest.approx(3.0),
    }  # fmt: skip
    assert summarise_estimates(()) == {}


def test_a_number_that_is_none_fails() -> None:
    """Fails if nan slipped through a comparison."""
    assert verdicts(seam_mismatch_mm=float("nan"))["seams"] == "fail"


def test_intersections_of_the_drape_are_not_charged_to_the_deformer() -> None:
    """Fails if the graded drape's own intersections were counted again."""
    found = verdicts(self_intersecting_faces=420.0, graded__self_intersecting_faces=400.0)
    assert found["self_intersections"] == "pass"


def test_messages_name_the_value_and_the_next_step() -> None:
    """Fails if a failing gate only named itself."""
    gates = {gate.name: gate for gate in evaluate_gates(GOOD | {"body_penetration_mm": 8.2})}
    assert "8.2 mm" in gates["penetration"].message
    assert "garmentq inspect" in gates["penetration"].message
    assert gates["penetration"].limit == 5.0
    assert worst_verdict(gate.verdict for gate in gates.values()) is Verdict.FAIL
    assert worst_verdict(()) is Verdict.PASS


def test_every_limit_has_a_reason_and_an_order() -> None:
    """Fails if a rule were added without its reason, or could fail before it warns."""
    for rule in GATE_RULES:
        assert rule.reason and rule.next_step
        assert rule.doubtful < rule.fail
