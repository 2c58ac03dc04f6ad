"""Where a deformation begins: on the scan and at the drape, or at the drape only."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover import steps
from garmentq.core.recover.deform.settings import DeformSettings
from garmentq.core.recover.fit import second_registration
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.recover.state import RecoveryState
from garmentq.core.run.clock import Clock
from garmentq.core.run.hooks import SILENT_HOOKS
from garmentq.core.scan.contours.target import Target


@pytest.mark.parametrize(
    ("preset", "is_laid", "count"), [("default", True, 2), ("default", False, 1), ("thesis", True, 1)]
)
@pytest.mark.parametrize(
    ("offsets", "crossed", "taken"), [((0.0, 0.01), (0, 0), 0), ((0.01, 0.0), (0, 0), 1), ((0.0, 0.01), (9, 2), 1)]
)
def test_a_deformation_begins_on_the_scan_too(
    monkeypatch,
    preset: str,
    is_laid: bool,
    count: int,
    offsets: tuple[float, float],
    crossed: tuple[int, int],
    taken: int,
) -> None:
    """Broken where only the drape's folds are tried, the further trial or one that crosses more is taken, a start is
    deformed twice, or the thesis is not followed."""
    worn = load_draped_template("skirt")
    assert worn is not None
    whole, tried, began, exposed = DeformSettings.of_preset(preset), [], [], object()

    def begin(garment, towards, skin, **options):
        assert towards is target and skin is exposed
        if options["settings"] == whole:
            began.append(garment.nodes)
            return SimpleNamespace(nodes=worn.nodes, warnings=("whole",))
        assert options["settings"] == whole.for_trial()
        tried.append(garment.nodes)
        return SimpleNamespace(nodes=worn.nodes + [0.0, offsets[len(tried) - 1], 0.0], warnings=("trial",))

    monkeypatch.setattr(steps, "deform", begin)
    monkeypatch.setattr(steps, "self_intersections", lambda *given: np.arange(crossed[len(tried) - 1]))
    monkeypatch.setattr(steps, "prove_corners", lambda *given: ())
    monkeypatch.setattr(steps, "fair_garment", lambda garment, *given: garment)
    target = Target(worn.nodes, worn.faces, np.zeros_like(worn.nodes), worn.contours, (), "skirt")
    settings = RecoverySettings(preset=preset)
    case = SimpleNamespace(settings=settings, scan_target=target, has_free_curves=True)
    laid = worn.nodes + [0.1, 0.0, 0.0] if is_laid else None
    state = RecoveryState(
        "skirt", worn.pattern, target, SimpleNamespace(exposed=exposed), None, garment=worn, graded=worn, laid=laid
    )
    clock = Clock()
    fit = steps.register(case, state, clock)
    choices = [finding.evidence for finding in clock.take_findings()]
    assert [len(choice["scores"]) for choice in choices] == [2] * (count - 1)
    assert len(tried) == (2 if count == 2 else 0) and len(began) == 1
    on_scan = count == 2 and taken == 0
    np.testing.assert_array_equal(began[0], laid if on_scan else worn.nodes)
    assert [one.message for one in fit.findings] == ["whole"]
    np.testing.assert_array_equal(fit.meshes.detail, worn.nodes)
    np.testing.assert_array_equal(fit.garment.nodes, fit.meshes.detail)
    np.testing.assert_array_equal(fit.meshes.graded, worn.nodes)


@pytest.mark.parametrize(
    ("first_off", "other_off", "kept"), [(0.002, 0.003, "other"), (0.002, 0.02, "second"), (0.0095, 0.0, "second")]
)
def test_the_nearer_of_two_second_registrations_is_kept(
    monkeypatch, first_off: float, other_off: float, kept: str
) -> None:
    """Broken where it begins anew without need or elsewhere than at the first, or the further one is kept."""
    worn = load_draped_template("skirt")
    assert worn is not None
    target = Target(worn.nodes, worn.faces, np.zeros_like(worn.nodes), worn.contours, (), "skirt")
    case = SimpleNamespace(settings=RecoverySettings())
    first, second, other = (worn.at(worn.nodes + [0.0, off, 0.0]) for off in (first_off, 0.01, other_off))

    exposed = object()

    def begin(garment, towards, skin, **options):
        assert towards is target and skin is exposed
        np.testing.assert_allclose(garment.nodes, first.nodes, atol=1e-9)
        return SimpleNamespace(nodes=other.nodes)

    monkeypatch.setattr(second_registration, "deform", begin)
    state = SimpleNamespace(target=target, wearer=SimpleNamespace(exposed=exposed))
    found = second_registration.choose_nearer_registration(first, second, case, state, SILENT_HOOKS)
    assert np.array_equal(found.nodes, {"second": second, "other": other}[kept].nodes)
