"""The whole road on trousers whose waist a top hides."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.garment.curves import panel_area
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.reading import Reading
from garmentq.core.garment.templates import load_template
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Recovery, Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.pieces import ScanInput
from garmentq.core.scan.scan import Scan
from wearers import find_wearer

WEARER = "builtin:female,height=1.68,pose=A"
COVERED = 0.18
"""Height below the waist down to which a top hangs [m]."""
HIP = 0.18
"""Depth below the waist at which the trousers are as wide as they get [m]."""


def widen(base: Pattern) -> Pattern:
    """Return trousers 6 % wider from the hips down; a wider waist would hang 3 cm lower, of which nothing is seen."""
    points = base.points.copy()
    for panel, first in zip(base.panels, base.point_starts, strict=False):
        own = points[first : first + len(panel.points)]
        below = np.clip((own[:, 1].max() - own[:, 1]) / HIP, 0.0, 1.0)
        own[:, 0] *= 1.0 + 0.06 * below
    return base.with_points(points)


@pytest.fixture(scope="module")
def recovery(tmp_path_factory: pytest.TempPathFactory) -> Recovery:
    """Recover trousers that are wider than their base pattern, seen below the hem of a top alone."""
    worn = drape_template(widen(load_template("trousers")), find_wearer(WEARER), settings=DrapeSettings(1500).eased())
    waist = next(contour for contour in worn.contours if contour.name == "waist")
    hem = worn.nodes[waist.vertices, 1].min() - COVERED
    used, faces = np.unique(worn.faces[(worn.nodes[worn.faces][:, :, 1] < hem).all(axis=1)], return_inverse=True)
    nodes, faces = worn.nodes[used], faces.reshape(-1, 3)
    hidden = np.zeros(len(nodes), bool)
    hidden[max(find_loops(faces), key=lambda loop: nodes[loop, 1].mean())] = True
    pieces = ScanInput(Scan(nodes, faces, name="trousers", hidden=hidden), None)
    settings = RecoverySettings(method="deform", vertex_count=1000, template="trousers")
    return recover(
        Request(tmp_path_factory.mktemp("scan"), BuiltinWearer(WEARER), settings=settings, reading=Reading(pieces))
    )


@pytest.mark.nightly
def test_trousers_do_not_end_where_a_top_covers_them(recovery: Recovery) -> None:
    """Fails if the pattern were cut off at the top's hem, which takes a fifth of its area, or drawn out above it."""
    for ours, panel in zip(recovery.pattern.panels, widen(load_template("trousers")).panels, strict=True):
        assert panel_area(ours) == pytest.approx(panel_area(panel), rel=0.06)


@pytest.mark.nightly
def test_what_is_guessed_is_said_and_not_measured(recovery: Recovery) -> None:
    """Fails if hidden cloth counted as a misfit, or if nothing told that a part is the base pattern's."""
    waist = recovery.target.contour("waist")
    assert waist is not None
    assert not waist.trusted
    assert len(recovery.target.vertices) == len(recovery.scan.vertices)
    assert recovery.report.metrics["surface_rms_mm.s2t"] < 2.5
    assert 10.0 < recovery.report.metrics["hidden_percent"] < 40.0
    assert {gate.name: gate.verdict for gate in recovery.report.gates}["hidden"] == "doubtful"
    assert any("'waist' is hidden" in warning for warning in recovery.report.warnings)
