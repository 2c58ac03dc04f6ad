"""Files in which little or nothing of a person is left: the points are read, or they are refused by name."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from garmentq.cli.inspect import command as inspect
from garmentq.core.body.builtin import builtin_body
from garmentq.core.people.person_input import PersonInput, describe_person_input
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.limits import Limits
from garmentq.core.scan.load import load_scan
from garmentq.core.scan.load_raw import load_raw

INSIDE = Limits(is_confined=True)
"""Parsing here: a process for each file would take most of the time."""
RNG = np.random.default_rng(0)
BODY = builtin_body("builtin:female,height=1.70")
SQUARE = np.stack(np.meshgrid(np.linspace(0, 2, 60), np.linspace(0, 2, 60)), -1).reshape(-1, 2)
FLOOR = np.column_stack([SQUARE[:, 0], np.zeros(3600), SQUARE[:, 1]])
SOUP = RNG.random((3000, 3)) * [0.5, 1.7, 0.3]
BOX = trimesh.creation.box((1, 2, 1)).subdivide().subdivide().subdivide()
LINE = np.linspace(0, 1.7, 500)[:, None]
DUST = trimesh.util.concatenate(
    [trimesh.creation.box((0.01, 0.01, 0.01)).apply_translation(place) for place in SOUP[:800]]
)

CASES = {
    "floor": (FLOOR, None),
    "rough floor": (FLOOR + 1e-4 * RNG.standard_normal(FLOOR.shape), None),
    "corner of a room": (np.concatenate([FLOOR, FLOOR[:, [1, 0, 2]], FLOOR[:, [0, 2, 1]]]), None),
    "line": (LINE * [1.0, 1.0, 1.0], None),
    "pole": (LINE * [0.0, 1.0, 0.0], None),
    "two places": (np.repeat([[0.0, 0, 0], [0, 1.7, 0]], 300, axis=0), None),
    "three places": (np.repeat([[0.0, 0, 0], [0, 1.7, 0], [1, 1, 1]], 300, axis=0), None),
    "noise": (RNG.random((3000, 3)), None),
    "few with a position": (np.where(np.arange(3000)[:, None] < 2850, np.nan, RNG.random((3000, 3))), None),
    "box": (BOX.vertices, BOX.faces),
    "soup": (SOUP, np.arange(3000).reshape(-1, 3)),
    "little soup": (SOUP[:300], np.arange(300).reshape(-1, 3)),
    "faces without an area": (np.repeat(SOUP[:1000], 3, axis=0), np.arange(3000).reshape(-1, 3)),
    "one face": (SOUP, np.array([[0, 1, 2]])),
    "dust": (DUST.vertices, DUST.faces),
}


def write(path: Path, points: np.ndarray, faces: np.ndarray | None) -> Path:
    """Write a mesh, or a cloud."""
    mesh = trimesh.PointCloud(points) if faces is None else trimesh.Trimesh(points, faces, process=False)
    mesh.export(path)
    return path


@pytest.mark.parametrize("case", CASES)
def test_what_is_no_person_is_read_or_refused_by_name(tmp_path, case):
    """Broken where any of the readers ends in a traceback, or divides by nothing, where cleaning leaves no point."""
    path = write(tmp_path / "a.ply", *CASES[case])
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        for read in (load_raw, lambda path, limits: load_scan(path, kind="body", limits=limits), load_scan):
            try:
                found = read(path, limits=INSIDE)
            except BadInput as error:
                assert error.code.startswith("scan.") and "\n" not in error.message
                continue
            if read is load_raw:
                assert len(found.points) >= 100
                assert np.isfinite(describe_person_input(PersonInput(found))["scan"]["extent_m"]).all()


@pytest.fixture(scope="module")
def made_up(tmp_path_factory) -> Path:
    """Write a person's cloud with made-up faces (0, 1, 2), (3, 4, 5), ..., its points in no order."""
    mesh = trimesh.Trimesh(BODY.vertices, BODY.faces, process=False)
    points = trimesh.sample.sample_surface(mesh, 12_000, seed=0)[0]
    points = np.random.default_rng(1).permutation(points)
    return write(tmp_path_factory.mktemp("made_up") / "p.ply", points, np.arange(12_000).reshape(-1, 3))


def test_a_cloud_with_made_up_faces_is_a_cloud(made_up):
    """Broken where faces that join nothing make cleaning drop every point, or are kept as a surface."""
    raw = load_raw(made_up, limits=INSIDE)
    assert raw.is_cloud and len(raw.points) > 11_000 and raw.up_axis == "y"
    assert np.ptp(raw.points[:, 1]) == pytest.approx(np.ptp(BODY.vertices[:, 1]), abs=0.02)
    assert any("faces are no surface" in note for note in raw.notes)
    assert len(raw.place) == 12_000 and (raw.place >= 0).mean() > 0.95


def test_a_garment_of_made_up_faces_is_refused_by_name(made_up):
    """Broken where thousands of loose triangles are taken for a garment, or end in a traceback."""
    with pytest.raises(BadInput) as caught:
        load_scan(made_up, limits=INSIDE)
    assert caught.value.code == "scan.units_unknown"  # the area of all triangles is no garment's in any unit


@pytest.mark.parametrize("said", [[], ["--as", "garment"]])
def test_inspect_ends_without_a_traceback(made_up, said):
    """Broken where the command that says how a file is understood fails itself."""
    answer = CliRunner().invoke(inspect, [str(made_up), "--json", *said])
    assert answer.exception is None or isinstance(answer.exception, SystemExit | BadInput), answer.exception
    if answer.exit_code == 0:
        assert json.loads(answer.output)["scan"]["is_cloud"]
