"""The whole road on a small garment: what comes out, and that a resumed run ends where an uninterrupted one does."""

from __future__ import annotations

import signal
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body import Body, BodyMissing, builtin_body
from garmentq.core.checkpoints import keep_body, kept_body
from garmentq.core.drape import DrapeSettings, WearerGeometry, drape_template
from garmentq.core.hooks import Hooks
from garmentq.core.pattern import load_template
from garmentq.core.pipeline import recover
from garmentq.core.recovery import STAGES, Recovery, Request
from garmentq.core.settings import RecoverySettings

WEARER = "builtin:female,height=1.68,pose=A"


@pytest.fixture(scope="module")
def request_of_a_skirt(tmp_path_factory: pytest.TempPathFactory) -> Request:
    """Write a skirt 12 % longer and 6 % wider than the template, worn by the built-in body."""
    base = load_template("skirt")
    longer = base.with_points(base.points * np.array([1.06, 1.12]))
    wearer = WearerGeometry(builtin_body(WEARER))
    garment = drape_template(longer, wearer, settings=DrapeSettings(template_vertices=900))
    path = tmp_path_factory.mktemp("scan") / "skirt.ply"
    trimesh.Trimesh(garment.nodes, garment.faces, process=False).export(path)
    return Request(path, WEARER, settings=RecoverySettings(method="deform", vertex_count=800))


@pytest.fixture(scope="module")
def straight(request_of_a_skirt: Request) -> Recovery:
    """Recover it without interruption."""
    return recover(request_of_a_skirt)


@pytest.mark.slow
def test_pattern_and_detail_are_recovered(straight: Recovery) -> None:
    """Breaks if a stage hands on the wrong mesh, or if grading goes the wrong way."""
    assert straight.target.category == "skirt"
    assert straight.template == "skirt"
    assert set(straight.stage_seconds) == set(STAGES) - {"fit", "redrape"}
    for way in ("s2t", "t2s"):
        detail, graded = (straight.metrics[f"{prefix}surface_rms_mm.{way}"] for prefix in ("", "graded."))
        assert detail is not None and graded is not None
        assert detail < 2.0
        assert detail < graded < 30.0
    assert (straight.metrics["body_penetration_mm"] or 0.0) <= 1.0
    height = np.ptp(straight.pattern.panels[0].points[:, 1])
    assert height == pytest.approx(1.12 * np.ptp(load_template("skirt").panels[0].points[:, 1]), rel=0.06)


KILLED = """
import os, signal, sys
from pathlib import Path
import numpy as np
from garmentq.core.hooks import Hooks
from garmentq.core.pipeline import recover
from garmentq.core.recovery import Request
from garmentq.core.settings import RecoverySettings

scan, wearer, vertices, folder = sys.argv[1:]

def save(name, arrays):
    np.savez(Path(folder) / name, **arrays)
    os.kill(os.getpid(), signal.SIGKILL)

recover(Request(Path(scan), wearer, settings=RecoverySettings(method="deform", vertex_count=int(vertices))),
        Hooks(save_checkpoint=save))
"""
"""Recover in a process of its own that is killed right after the first checkpoint it kept."""


@pytest.mark.slow
def test_resumed_run_ends_where_an_uninterrupted_one_does(
    request_of_a_skirt: Request, straight: Recovery, tmp_path: Path
) -> None:
    """Breaks if a checkpoint loses something that the later stages need, or if a process's digits are its own.

    `tests/chaos/resume.py` does the same through the job table and for every checkpoint of every method.
    """
    vertices = str(request_of_a_skirt.settings.vertex_count)
    arguments = [str(request_of_a_skirt.scan), WEARER, vertices, str(tmp_path)]
    killed = subprocess.run([sys.executable, "-c", KILLED, *arguments], check=False)
    assert killed.returncode == -signal.SIGKILL
    kept = {path.stem: dict(np.load(path)) for path in tmp_path.iterdir()}
    assert list(kept) == ["drape"]
    stages: list[str] = []

    def note(stage: str, fraction: float, message: str) -> None:
        stages.append(stage)

    resumed = recover(request_of_a_skirt, Hooks(on_progress=note, load_checkpoint=kept.get))
    assert "grade" not in stages, "the graded drape was kept"
    assert np.abs(resumed.detail - straight.detail).max() < 1e-6
    assert np.abs(resumed.graded - straight.graded).max() < 1e-6
    assert np.abs(resumed.pattern.points - straight.pattern.points).max() < 1e-6
    assert resumed.metrics["drape.residual"] == straight.metrics["drape.residual"]


def test_body_is_kept_whole() -> None:
    """Breaks if a field of the body is added and not kept."""
    kept: dict[str, dict[str, np.ndarray]] = {}
    hooks = Hooks(
        save_checkpoint=lambda name, arrays: kept.update({name: dict(arrays)}),
        load_checkpoint=lambda name: kept.get(name),
    )
    assert kept_body(hooks) is None
    body = replace(builtin_body(WEARER), fit_rms=0.003)
    keep_body(hooks, body)
    found = kept_body(hooks)
    assert isinstance(found, Body)
    for field in fields(Body):
        ours, theirs = getattr(body, field.name), getattr(found, field.name)
        if field.name == "parameters":
            assert set(ours) == set(theirs) and all(np.array_equal(ours[name], theirs[name]) for name in ours)
        else:
            assert np.array_equal(ours, theirs)


def test_garment_without_body_is_refused_with_the_next_step(tmp_path: Path) -> None:
    """Breaks if a missing body is guessed, or found out only after the scan was read."""
    with pytest.raises(BodyMissing, match="builtin:female"):
        recover(Request(tmp_path / "skirt.ply"))
