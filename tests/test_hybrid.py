"""The hybrid method on the whole road, from a stranger's pattern file: what comes out, and of what it is told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.deliver.export.result import write_recovery
from garmentq.core.garment.curves import panel_area
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.meshes import Meshes
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_draped_template, load_template
from garmentq.core.recover import pipeline, steps
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.fit.locks import LockUnknown
from garmentq.core.recover.methods import METHODS
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import STAGES, Recovery, Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.recover.state import RecoveryState
from garmentq.core.run.clock import Clock
from garmentq.core.run.errors import Cancelled, GarmentqError
from wearers import WOMAN, find_wearer

WEARER = WOMAN
"""In the T-pose: no drape takes a pose; `test_pipeline.py` recovers on a wearer in another one."""

WIDER, LONGER = 1.05, 1.08
"""The scanned skirt against the stranger's pattern."""


def draw_skirt() -> dict:
    """Return a skirt in the GarmentCode format: centimetres, its back drawn clockwise, names of its author's own."""
    side = lambda panel, edge: {"panel": panel, "edge": edge}  # noqa: E731
    edges = [{"endpoints": [i, (i + 1) % 4]} for i in range(4)]
    corners = [[0, 0], [64, 0], [52, 54], [12, 54]]
    front = {"translation": [-32, 50, 20], "rotation": [0, 0, 0], "vertices": corners, "edges": edges}
    back = front | {"translation": [-32, 50, -20], "vertices": [corners[i] for i in (0, 3, 2, 1)]}
    stitches = [[side("Vorn", 1), side("Hint", 2)], [side("Vorn", 3), side("Hint", 0)]]
    return {
        "pattern": {"panels": {"Vorn": front, "Hint": back}, "stitches": stitches},
        "properties": {"curvature_coords": "relative", "normalize_panel_translation": False, "units_in_meter": 100},
    }


@pytest.fixture(scope="module")
def recovered(tmp_path_factory: pytest.TempPathFactory) -> Recovery:
    """Recover a skirt that was cut wider and longer than the stranger's pattern."""
    folder = tmp_path_factory.mktemp("stranger")
    (folder / "rock.json").write_text(json.dumps(draw_skirt()))
    base = load_pattern(folder / "rock.json")
    true = base.with_points(base.points * [WIDER, LONGER])
    worn = drape_template(true, find_wearer(WEARER), settings=DrapeSettings(template_vertices=700))
    trimesh.Trimesh(worn.nodes, worn.faces, process=False).export(folder / "scan.ply")
    settings = RecoverySettings(method="hybrid", vertex_count=500, lock="point:Vorn/2")
    return recover(
        Request(folder / "scan.ply", BuiltinWearer(WEARER), template=folder / "rock.json", settings=settings)
    )


@pytest.mark.nightly  # by day the golden scenes begin with the patterns of strangers
def test_a_strangers_pattern_is_the_base(recovered: Recovery, tmp_path: Path) -> None:
    """Breaks if an imported pattern is replaced by a shipped one, graded by half or too far, or its panels renamed."""
    assert recovered.template == "rock"
    assert set(recovered.report.stage_seconds) == set(STAGES)
    (tmp_path / "rock.json").write_text(json.dumps(draw_skirt()))
    base = load_pattern(tmp_path / "rock.json")
    for panel in recovered.pattern.panels:
        drawn = base.panel(panel.name)
        longer = np.ptp(panel.points[:, 1]) / np.ptp(drawn.points[:, 1])
        wider = panel_area(panel) / panel_area(drawn) / longer
        assert longer == pytest.approx(1.125, abs=0.02)  # and not LONGER, for worn cloth is longer than its pattern
        assert wider == pytest.approx(WIDER, abs=0.025)
    assert seam_mismatch(recovered.pattern) < 1e-5
    write_recovery(recovered, tmp_path / "out")
    again = json.loads((tmp_path / "out" / "pattern.json").read_text())
    assert set(again["pattern"]["panels"]) == {"Vorn", "Hint"}
    drawn = np.array(again["pattern"]["panels"]["Hint"]["vertices"])
    x, y = (drawn - drawn[0]).T
    assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0.0  # clockwise, as its author draws it


@pytest.mark.nightly
def test_fit_and_new_drape_are_reported_beside_each_other(recovered: Recovery) -> None:
    """Breaks if a mesh has another topology, or the new drape or what is known of the cloth stays unmeasured."""
    count = len(recovered.garment.nodes)
    assert [name for name, _ in recovered.meshes] == ["graded", "detail", "simulation", "redrape"]
    assert all(nodes.shape == (count, 3) for _, nodes in recovered.meshes)
    for prefix, limit in (("", 1.4), ("sim.", 13.0), ("redrape.", 20.0)):  # 0.7, 8.6 and 14.2 were measured
        for way in ("s2t", "t2s"):
            value = recovered.report.metrics[f"{prefix}surface_rms_mm.{way}"]
            assert value is not None and 0.0 < value < limit
    assert recovered.report.metrics["fabric.density.identifiable"] == 0.0
    assert recovered.report.metrics["fabric.k.std"] > 0.0
    assert recovered.report.metrics["redrape.residual"] is not None
    assert recovered.nearest_fabrics and recovered.point_std.shape == recovered.pattern.points.shape
    assert {estimate.name for estimate in recovered.estimates} == {"H00", "H01", "H11", "H22", "k", "density"}
    assert "simulation_fit" in {gate.name for gate in recovered.report.gates}


def test_a_fit_that_fails_leaves_the_graded_pattern(monkeypatch: pytest.MonkeyPatch) -> None:
    """Breaks if a result that is usable without the fit is thrown away with it, or a cancelled job goes on."""

    def fail(*arguments: object, **options: object) -> None:
        raise error

    garment = mesh_pattern(load_template("skirt"), 300)
    meshes = Meshes(garment.nodes, garment.nodes)
    graded = RecoveryState("skirt", garment.pattern, None, None, None, garment=garment, graded=garment, meshes=meshes)
    graded = graded.with_notes("the hem is frayed")
    monkeypatch.setattr(steps, "fit_pattern", fail)
    for error in (GarmentqError("the cloth is knotted."), np.linalg.LinAlgError("singular")):
        clock = Clock()
        found = graded
        for step in METHODS["hybrid"][-2:]:
            found = step(None, found, clock)
        assert found.garment is garment and found.meshes.simulation is None
        told = [finding.message for finding in found.findings]
        assert told[0] == "the hem is frayed"
        assert "the pattern is the graded one" in told[1] and str(error) in told[1]
        assert set(clock.seconds) == {"fit"}
    error = Cancelled()
    with pytest.raises(Cancelled):
        steps.FitShape()(None, graded, Clock())


def test_a_lock_of_nothing_is_refused_before_the_drape(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Breaks if a misspelt panel is found out only after a minute's work."""
    worn = load_draped_template("skirt")
    trimesh.Trimesh(worn.nodes, worn.faces, process=False).export(tmp_path / "scan.ply")
    monkeypatch.setattr(pipeline, "run_steps", lambda *arguments: pytest.fail("draped"))
    with pytest.raises(LockUnknown, match="nowhere"):
        recover(Request(tmp_path / "scan.ply", BuiltinWearer(WEARER), settings=RecoverySettings(lock="panel:nowhere")))
