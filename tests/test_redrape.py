"""A re-drape that was left for later finds what it would have found in its place, to the last bit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.garment.templates import load_template
from garmentq.core.recover.delivery import deliver
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.methods import GRADING_STEPS
from garmentq.core.recover.pipeline import finish, run_steps
from garmentq.core.recover.recovery import Recovery, Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.recover.start import choose_base, read_case
from garmentq.core.recover.steps import drape_anew, register
from garmentq.core.run.clock import Clock
from garmentq.core.run.hooks import Hooks
from garmentq.service.kinds.redrape_request import RedrapeRequest
from garmentq.service.kinds.unfinished import keep_unfinished, load_unfinished
from wearers import find_wearer

WEARER = "builtin:female,height=1.68,pose=A"


@pytest.fixture(scope="module")
def recover_skirt(tmp_path_factory: pytest.TempPathFactory):
    """Return a function that ends the recovery of a skirt as a re-drape's setting says; its pattern is the graded one.

    Its graded drape stands for the simulation mesh, since a fit takes longer than all else together.
    """
    path = tmp_path_factory.mktemp("scan") / "skirt.ply"
    worn = drape_template(load_template("skirt"), find_wearer(WEARER), settings=DrapeSettings(template_vertices=600))
    trimesh.Trimesh(worn.nodes, worn.faces, process=False).export(path)
    request = Request(path, BuiltinWearer(WEARER), settings=RecoverySettings(vertex_count=500))
    case = read_case(request, Clock())
    state = run_steps((*GRADING_STEPS, register), case, choose_base(case), Clock())
    meshes = replace(state.meshes, simulation=state.meshes.graded)
    state = replace(state, meshes=meshes, simulated=state.drape)

    def end(redrape: str | None) -> Recovery:
        asked = replace(case, request=replace(request, settings=replace(request.settings, redrape=redrape)))
        clock = Clock()
        return deliver(asked, run_steps((drape_anew,), asked, state, clock), clock)

    return end


@pytest.mark.slow
def test_redrape_finds_later_what_it_finds_at_once(recover_skirt, tmp_path: Path) -> None:
    """Breaks where what is kept of a recovery loses a bit that its re-drape needs, or its metrics are others' then."""
    at_once, later = recover_skirt(None), recover_skirt("later")
    assert later.meshes.redraped is None and later.report.metrics["redrape_missing"] == 1.0
    later.report.metrics["confidence"] = 0.5
    keep_unfinished(later, tmp_path)
    kept, saved = load_unfinished(tmp_path), {}
    case = kept.make_case(RedrapeRequest(later.case.settings))
    done = finish(case, kept.state, kept.metrics, Hooks(save_checkpoint=saved.__setitem__))
    assert done.report.metrics == at_once.report.metrics | {"confidence": 0.5}
    np.testing.assert_array_equal(done.meshes.redraped, at_once.meshes.redraped)
    assert type(done) is Recovery
    for field in ("gates", "warnings", "manifest"):
        assert getattr(done.report, field) == getattr(at_once.report, field)
    assert set(kept.add_cost(done.report).stage_seconds) == {"redrape", "measure"}

    stages: list[str] = []
    hooks = Hooks(on_progress=lambda stage, *_: stages.append(stage), load_checkpoint=saved.get)
    resumed = finish(case, kept.state, kept.metrics, hooks)
    assert set(stages) == {"measure"} and resumed.report.metrics == done.report.metrics


@pytest.mark.slow
def test_result_without_a_redrape_says_so(recover_skirt) -> None:
    """Breaks where a pattern that was not sewn again passes as if it had been."""
    found = recover_skirt("never")
    (gate,) = [one for one in found.report.gates if one.name == "redrape"]
    assert gate.verdict == "doubtful" and "--redrape wait" in gate.message
    assert type(found) is Recovery and not [name for name in found.report.metrics if name.startswith("redrape.")]
