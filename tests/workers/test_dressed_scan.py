"""A dressed person with two garments through a real broker, a real Celery worker and the real pipeline."""

from __future__ import annotations

import json

import igl
import numpy as np
import pytest
import trimesh
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.service.settings import CHECKER, PIPELINE, WRITER
from garmentq.workers.embedded import ensure_services, stop_services
from garmentq_home import Cli, make_environment, make_settings

WEARER = "builtin:female,height=1.66,pose=A"
SHIRT = ("spine1", "spine2", "spine3", "left_collar", "right_collar", "left_shoulder", "right_shoulder")
SHORTS = ("pelvis", "left_hip", "right_hip")


def write_person(path):
    """Lift the skin of the chest into a T-shirt and that of the hips into shorts; labels 1 and 2, the skin 0."""
    body = builtin_body(WEARER)
    part = np.array(JOINTS)[body.weights.argmax(axis=1)]
    vertices, faces = trimesh.remesh.subdivide(body.vertices, body.faces)
    corner = body.faces[igl.point_mesh_squared_distance(vertices, body.vertices, body.faces)[1], 0]
    label = np.where(np.isin(part[corner], SHIRT), 1, np.where(np.isin(part[corner], SHORTS), 2, 0))
    noise = np.random.default_rng(0).normal(0.0, 1e-3, vertices.shape)
    lifted = vertices + 0.012 * (label > 0)[:, None] * vertex_normals(vertices, faces) + noise
    mesh = trimesh.Trimesh(lifted, faces, process=False)
    mesh.vertex_attributes["label"] = label.astype(np.uint8)
    mesh.export(path)
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    "garments",
    [
        pytest.param({"--keep": {"2": "shorts"}, "--cloth": {"1": ""}}, id="shorts", marks=pytest.mark.nightly),
        pytest.param({"--keep": {"1": "tshirt", "2": "shorts"}}, id="both", marks=pytest.mark.nightly),
    ],
)
def test_each_garment_of_a_scan_is_recovered(garments, tmp_path, blank_database, monkeypatch):
    """Broken where labels get lost between the command line and the worker, or one garment is recovered twice."""
    home = tmp_path / "home"
    home.mkdir(mode=0o700)
    settings = make_settings(home, pipeline=PIPELINE, writer=WRITER, checker=CHECKER, lease_seconds=60.0)
    for name, value in make_environment(settings).items():
        monkeypatch.setenv(name, value)
    cli = Cli(settings)
    person = write_person(tmp_path / "person.ply")
    ensure_services(settings, workers=1)
    chosen = [word for option, labels in garments.items() for label in labels for word in (option, label)]
    try:
        done = cli("submit", person, *chosen, *"--method deform --vertices 500 --wait".split())
        assert done.returncode == 0, done.stderr
        jobs = [line.split()[0] for line in done.stdout.splitlines()]
        found = [json.loads(cli("result", job, "--json").stdout) for job in jobs]
    finally:
        stop_services(settings)
    assert len(set(jobs)) == len(jobs)
    assert [one["garment"] for one in found] == list(garments["--keep"].values())
    for one in found:
        assert one["state"] == "succeeded" and one["body"].startswith("scan:")
        assert one["metrics"]["body.fit_rms_mm"] < 4.0, "the other garment must not count as skin"
        assert one["metrics"]["surface_rms_mm.t2s"] < 8.0
