"""Bodies by Anny's parameters: the same vertices as the `anny` package computes, and the same parameters out again."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from garmentq.cli.main import group
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.model_arrays import BodyModelBad, BodyModelUnsupported
from garmentq.core.body.models.anny import JOINT_BONES, PHENOTYPES, AnnyPerson, load_anny_model, make_anny_body
from garmentq.core.body.models.anny_file import load_anny, read_person, write_anny
from garmentq.core.body.models.model_file import load_body_model
from garmentq.core.body.posing import pose_body
from garmentq.core.body.skinning import skin
from garmentq.core.body.spec import is_body_model
from garmentq.core.recover.inputs import read_files
from garmentq.core.recover.recovery import Request
from garmentq.core.run.errors import NotFound
from hypothesis import given, settings
from hypothesis import strategies as st

from .anny_reference import REFERENCE, VERTEX_STEP, compute_with_anny, make_model, make_persons

MODEL = load_anny_model()
STORED = json.loads(REFERENCE.read_text())
SKIN_COUNT = len(MODEL.vertex_numbers)
COLUMNS = [MODEL.bones.index(bone) for bone in JOINT_BONES.values()]


@pytest.mark.parametrize("at", range(len(STORED)))
def test_vertices_and_joints_are_those_that_anny_computed(at, tmp_path):
    """Broken where a target, its weight, a bone's orientation or the chain of bones is not Anny's, by 1e-6 m."""
    path = tmp_path / "anna.json"
    path.write_text(json.dumps(STORED[at]["person"]))
    body = load_body_model(path)
    assert np.abs(body.vertices[:SKIN_COUNT][::VERTEX_STEP] - STORED[at]["vertices"]).max() < 1e-6
    assert np.abs(body.joints - np.array(STORED[at]["heads"])[COLUMNS]).max() < 1e-6
    assert body.source == "anny:anna"


@pytest.mark.skipif(importlib.util.find_spec("anny") is None, reason="the anny package is a developer's")
def test_all_vertices_are_those_that_anny_computes():
    """Broken where a vertex that the stored numbers leave out is elsewhere, or another release of Anny differs."""
    model = make_model()
    for person in make_persons():
        vertices, _ = compute_with_anny(model, person)
        body = make_anny_body(read_person(person))
        assert np.abs(body.vertices[:SKIN_COUNT] - vertices[MODEL.vertex_numbers]).max() < 1e-6


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.0, 1.0), min_size=len(PHENOTYPES), max_size=len(PHENOTYPES)))
def test_parameters_come_out_as_they_went_in(values):
    """Broken where a parameter is rounded, reordered or left out on the way through JSON."""
    person = read_person({"phenotype_kwargs": dict(zip(PHENOTYPES, values, strict=True))})
    body = builtin_body("builtin:female")
    body.parameters.clear()
    body.parameters["phenotypes"] = person.phenotypes
    again = read_person(json.loads(write_anny(body)))
    assert again.phenotypes.tolist() == values and again.pose is None


def test_a_pose_comes_out_as_it_went_in(tmp_path):
    """Broken where a bone's transform changes in a digit, or the file that is written makes another body."""
    path = tmp_path / "in.json"
    path.write_text(json.dumps(STORED[3]["person"]))
    body = load_anny(path)
    (tmp_path / "out.json").write_text(write_anny(body))
    again = load_anny(tmp_path / "out.json")
    assert np.array_equal(again.vertices, body.vertices)
    assert json.loads(write_anny(again))["pose_parameters"] == STORED[3]["person"]["pose_parameters"]


def test_the_file_may_be_arrays(tmp_path):
    """Broken where an .npz of the same parameters is another body, or is taken for SMPL's."""
    person = read_person(STORED[3]["person"])
    values = dict(zip(PHENOTYPES, person.phenotypes, strict=True))
    np.savez(tmp_path / "x.npz", pose_parameters=person.pose[None], **values)
    body = load_body_model(tmp_path / "x.npz")
    assert np.array_equal(body.vertices, make_anny_body(person).vertices)


def test_the_rest_is_a_closed_t_pose():
    """Broken where arms are not level, feet not on the floor, skin open, or the skinning does not lead to the pose."""
    body = make_anny_body(AnnyPerson(np.array([1.0, 0.7, *[0.5] * 9])))
    for side in ("left", "right"):
        arm = body.rest_joints[[JOINTS.index(f"{side}_{one}") for one in ("shoulder", "elbow", "wrist", "hand")]]
        assert np.abs(arm - arm[0])[:, 1:].max() < 1e-9
    assert body.rest_vertices[:, 1].min() == pytest.approx(0.0, abs=1e-12)
    mesh = trimesh.Trimesh(body.rest_vertices, body.rest_faces, process=False)
    assert mesh.is_watertight and mesh.volume > 0.04
    off = skin(body.rest_vertices, body.rest_weights, body.transforms) - body.vertices
    assert np.sqrt((off**2).sum(axis=1).mean()) == pytest.approx(body.fit_rms) and body.fit_rms < 5e-3
    assert pose_body(body, "A").parameters["phenotypes"][1] == 0.7


@pytest.mark.parametrize(
    ("document", "error", "word"),
    [
        ({"gender": 1.4}, BodyModelBad, "gender is 1.4"),
        ({"age": -0.2}, BodyModelUnsupported, "below one year"),
        ({"age": 0.0, "height": 0.0}, BodyModelBad, "m high"),
        ({"hieght": 0.5}, BodyModelBad, "'hieght' is no phenotype"),
        ({"gender": [0.1, 0.2]}, BodyModelBad, "one person"),
        ({"gender": "female"}, BodyModelBad, "no finite number"),
        ({"gender": 10**400}, BodyModelBad, "no finite number"),
        ({}, BodyModelBad, "none of Anny's"),
        ({"phenotype_kwargs": [0.5]}, BodyModelBad, "names"),
        ({"gender": 1, "local_changes_kwargs": {"hip-scale-horiz-incr": 0.3}}, BodyModelUnsupported, "hip-scale"),
        ({"gender": 1, "facial_actions": {"smile": 1.0}}, BodyModelUnsupported, "smile"),
        ({"gender": 1, "pose_parameters": {"tongue00": np.eye(4).tolist()}}, BodyModelUnsupported, "tongue00"),
        ({"gender": 1, "pose_parameters": {"root": [[2, 0], [0, 1]]}}, BodyModelBad, "4 x 4"),
        ({"gender": 1, "pose_parameters": {"root": (2 * np.eye(4)).tolist()}}, BodyModelBad, "no rotation"),
        (
            {"gender": 1, "pose_parameterization": "world", "pose_parameters": {"root": 1}},
            BodyModelUnsupported,
            "world",
        ),
    ],
)
def test_what_is_not_annys_is_refused_by_its_name(document, error, word, tmp_path):
    """Broken where a slip, or what the data lack, gives a body as if it were not there."""
    (tmp_path / "x.json").write_text(json.dumps(document))
    with pytest.raises(error, match=word):
        load_body_model(tmp_path / "x.json")


@pytest.mark.parametrize("content", [b"", b"[1]", b"{" * 5000, b"\xff\xfe", b'{"gender": NaN}', b" " * (1 << 21)])
def test_garbage_is_refused(content, tmp_path):
    """Broken where a file that is no JSON ends in a traceback."""
    (tmp_path / "x.json").write_bytes(content)
    with pytest.raises(BodyModelBad):
        load_body_model(tmp_path / "x.json")


def test_only_a_body_of_annys_is_written_as_one(tmp_path):
    """Broken where another body, or one posed since, is written by parameters that do not make it."""
    body = make_anny_body(AnnyPerson(np.full(11, 0.5)))
    for other in (builtin_body("builtin:male"), pose_body(body, "stride")):
        with pytest.raises(NotFound, match="no parameters of Anny's"):
            write_anny(other)


def test_a_recovery_takes_the_file_and_the_command_writes_it(tmp_path):
    """Broken where --body anny.json is parsed as a mesh, or `bodies export` loses a parameter."""
    path = tmp_path / "anna.json"
    path.write_text(json.dumps(STORED[2]["person"]))
    body = load_body_model(path)
    trunk = np.isin(body.weights.argmax(axis=1), [JOINTS.index(name) for name in ("spine1", "spine2", "spine3")])
    shell = trimesh.Trimesh(100 * body.vertices, body.faces[trunk[body.faces].all(axis=1)], process=False)
    shell.remove_unreferenced_vertices()
    shell.export(tmp_path / "top.ply")
    pieces = read_files(Request(scan=tmp_path / "top.ply", body=path))
    assert pieces.garment.units == "cm" and is_body_model(path)
    for name in ("out.json", "out.ply"):
        done = CliRunner().invoke(group, ["bodies", "export", str(path), "-o", str(tmp_path / name)])
        assert done.exit_code == 0, done.output
    assert (
        json.loads((tmp_path / "out.json").read_text())["phenotype_kwargs"] == STORED[2]["person"]["phenotype_kwargs"]
    )
    assert len(trimesh.load(tmp_path / "out.ply", process=False).vertices) == len(body.vertices)
    assert Path(tmp_path / "out_joints.json").exists()
