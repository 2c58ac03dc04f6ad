"""Bodies of MHR and SOMA from small made-up files: their joints become ours, and their skinning is their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.model_arrays import BodyModelBad, BodyModelUnsupported
from garmentq.core.body.models.model_file import load_body_model
from garmentq.core.body.posing import pose_body
from garmentq.core.body.skinning import skin
from garmentq.core.body.template import load_template
from scipy.sparse import csc_matrix
from scipy.spatial.transform import Rotation

from .made_up_rigs import MHR_NAMES, SOMA_NAMES, make_mhr, make_soma, stand

TEMPLATE = load_template()


def load(tmp_path: Path, data: dict[str, np.ndarray]):
    """Write the arrays, and return the body that is read."""
    np.savez(tmp_path / "anna.npz", **{name: value for name, value in data.items() if value is not None})
    return load_body_model(tmp_path / "anna.npz")


def carried(body) -> np.ndarray:
    """Return where a body's skinning takes its T-pose."""
    return skin(body.rest_vertices, body.rest_weights, body.transforms)


@pytest.mark.parametrize(("make", "names"), [(make_mhr, MHR_NAMES), (make_soma, SOMA_NAMES)])
def test_a_standing_model_is_read_with_our_joints(make, names, tmp_path):
    """Broken where centimetres pass as metres, a joint is taken for another, a finger's or face's weight is lost, or
    arms are not level in the T-pose."""
    body = load(tmp_path, make())
    vertices, joints = stand()
    assert np.abs(body.vertices - vertices).max() < 1e-6 and body.faces.tolist() == TEMPLATE.faces.tolist()
    hands = [JOINTS.index(f"{side}_hand") for side in ("left", "right")]
    others = np.setdiff1d(np.arange(24), hands)
    assert np.abs(body.joints - joints)[others].max() < 1e-6
    assert np.abs(body.joints - joints)[hands].max() < 0.04, "the mean of the knuckles"
    assert np.abs(body.weights - TEMPLATE.weights).max() < 1e-6
    for side in ("left", "right"):
        arm = body.rest_joints[[JOINTS.index(f"{side}_{one}") for one in ("shoulder", "elbow", "wrist", "hand")]]
        assert np.abs(arm - arm[0])[:, 1:].max() < 1e-9
    assert body.fit_rms < 1e-9 and np.abs(carried(body) - body.vertices).max() < 1e-9
    assert pose_body(body, "stride").joints.shape == (24, 3) and len(names) > 40


def test_mhrs_parameters_pose_it_as_momentum_does(tmp_path):
    """Broken where turns are in another order, a scale or prerotation is left out, or identity moves a wrong way."""
    data = make_mhr()
    rng = np.random.default_rng(5)
    data["identity_coeffs"] = rng.standard_normal(len(data["shape_vectors"]))
    parameters = np.concatenate([rng.normal(0.0, 0.2, 136), rng.normal(0.0, 0.05, 68)])
    body = load(tmp_path, data | {"model_parameters": parameters})
    shaped = data["base_shape"] + np.einsum("k,knd->nd", data["identity_coeffs"], data["shape_vectors"])
    own = (data["parameter_transform"] @ parameters).reshape(-1, 7)
    world, expected = [], np.zeros_like(shaped)
    weights = np.zeros((len(shaped), len(own)))
    weights[data["vert_indices_flattened"], data["skin_indices_flattened"]] = data["skin_weights_flattened"]
    for joint, (parent, one) in enumerate(zip(data["joint_parents"], own, strict=True)):
        turn = [Rotation.from_rotvec(angle * axis).as_matrix() for angle, axis in zip(one[3:6], np.eye(3), strict=True)]
        local = np.eye(4)
        local[:3, :3] = Rotation.from_quat(data["joint_prerotations"][joint]).as_matrix() @ turn[2] @ turn[1] @ turn[0]
        local[:3, :3] *= 2.0 ** one[6]
        local[:3, 3] = data["joint_translation_offsets"][joint] + one[:3]
        world.append(local if parent < 0 else world[parent] @ local)
        bind = data["inverse_bind_pose"][joint]
        inside = bind[7] * shaped @ Rotation.from_quat(bind[3:7]).as_matrix().T + bind[:3]
        expected += weights[:, joint, None] * (inside @ world[-1][:3, :3].T + world[-1][:3, 3])
    assert np.abs(body.vertices - 0.01 * expected).max() < 1e-9
    pelvis, elbow = MHR_NAMES.index("root"), MHR_NAMES.index("l_lowarm")
    assert body.joints[0] == pytest.approx(0.01 * world[pelvis][:3, 3], abs=1e-9)
    assert body.joints[JOINTS.index("left_elbow")] == pytest.approx(0.01 * world[elbow][:3, 3], abs=1e-9)
    turns = body.transforms[:, :3, :3]
    assert np.abs(turns @ np.swapaxes(turns, 1, 2) - np.eye(3)).max() < 1e-9
    assert body.parameters["model_parameters"].tolist() == parameters.tolist()
    coefficients = data.pop("identity_coeffs")
    sam = load(tmp_path, data | {"shape_params": coefficients, "mhr_model_params": parameters})
    assert np.array_equal(sam.vertices, body.vertices)
    with pytest.raises(BodyModelBad, match="without the model's arrays"):
        load(tmp_path, {"shape_params": coefficients, "mhr_model_params": parameters})


def test_somas_coefficients_move_vertices_and_joints(tmp_path):
    """Broken where an eigenvalue is no variance, directions are of other vertices, or joints stay where they were."""
    data = make_soma()
    coefficients = np.array([1.5, -0.5])
    body = load(tmp_path, data | {"identity_coeffs": coefficients})
    moves = (coefficients * np.sqrt(data["eigenvalues"])) @ data["shapedirs"]
    assert np.abs(body.vertices - 0.01 * (data["mean"] + moves.reshape(-1, 3))).max() < 1e-9
    plain = load(tmp_path, data)
    grown = load(tmp_path, data | {"mean": data["bind_shape"] + [0.0, 5.0, 0.0], "identity_coeffs": np.zeros(1)})
    assert np.abs(grown.joints - plain.joints - [0.0, 0.05, 0.0]).max() < 1e-9


def test_eyeballs_and_teeth_are_left_out(tmp_path):
    """Broken where a loose part inside the head is skin."""
    data = make_soma()
    ball = data["bind_shape"][:3] * 0.01 + data["bind_pose_world"][SOMA_NAMES.index("Head"), :3, 3]
    count = len(data["bind_shape"])
    loose = {
        "bind_shape": np.concatenate([data["bind_shape"], ball]),
        "triangles": np.concatenate([data["triangles"], [[count, count + 1, count + 2]]]),
    }
    matrix = csc_matrix(
        (data["skinning_weights_data"], data["skinning_weights_indices"], data["skinning_weights_indptr"]),
        shape=tuple(data["skinning_weights_shape"]),
    ).toarray()
    head = np.eye(len(SOMA_NAMES))[[SOMA_NAMES.index("Head")] * 3]
    packed = csc_matrix(np.concatenate([matrix, head]))
    loose |= {
        "skinning_weights_data": packed.data, "skinning_weights_indices": packed.indices,
        "skinning_weights_indptr": packed.indptr, "skinning_weights_shape": np.array(packed.shape),
    }  # fmt: skip
    assert len(load(tmp_path, data | loose).vertices) == count


@pytest.mark.parametrize(
    ("make", "changes", "error", "word"),
    [
        (make_mhr, {"joint_names": None}, BodyModelBad, "lacks joint_names"),
        (make_mhr, {"joint_parents": np.minimum(np.arange(len(MHR_NAMES)) - 1, 0)}, BodyModelBad, "no joint of it"),
        (make_mhr, {"joint_parents": np.full(len(MHR_NAMES), 3)}, BodyModelBad, "no tree"),
        (make_mhr, {"base_shape": np.array(["a"])}, BodyModelBad, "not numbers"),
        (make_mhr, {"faces": np.full((4, 3), 10**5)}, BodyModelBad, "no indices"),
        (make_mhr, {"model_parameters": np.zeros(205)}, BodyModelBad, "at most 204"),
        (make_mhr, {"model_parameters": np.full(204, 9.0)}, BodyModelBad, "scale a bone"),
        (make_mhr, {"model_parameters": np.zeros(9), "parameter_transform": None}, BodyModelBad, "lacks parameter"),
        (make_mhr, {"inverse_bind_pose": np.zeros((len(MHR_NAMES), 8))}, BodyModelBad, "no rotations"),
        (make_soma, {"poses": np.zeros((77, 3))}, BodyModelUnsupported, "--pose"),
        (make_soma, {"bind_shape": 0.01 * make_soma()["bind_shape"]}, BodyModelBad, "m high"),
        (make_soma, {"skinning_weights_indptr": np.zeros(len(SOMA_NAMES) + 1)}, BodyModelBad, "compressed columns"),
        (make_soma, {"identity_coeffs": np.zeros(3)}, BodyModelBad, "eigenvalues"),
        (make_soma, {"identity_coeffs": np.zeros(1), "mean": None}, BodyModelBad, "lacks mean"),
        (make_soma, {"joint_names": np.array([{"a": 1}], dtype=object)}, BodyModelBad, "object"),
    ],
)
def test_what_is_no_such_model_is_refused(make, changes, error, word, tmp_path):
    """Broken where a pickle is opened, or a wrong array becomes a wrong body or a traceback."""
    with pytest.raises(error, match=word):
        load(tmp_path, make() | changes)


CHANGES = {
    "zeros": np.zeros_like,
    "not numbers": lambda values: np.full(values.shape, np.nan),
    "infinite": lambda values: np.full(values.shape, np.inf),
    "huge": lambda values: values * 1e300,
    "negative": lambda values: -values,
    "backwards": lambda values: values[::-1],
    "shorter": lambda values: values[:-1],
    "flat": lambda values: values.ravel(),
    "nothing": lambda values: values[:0],
    "one number": lambda values: np.array(values.ravel()[0]),
    "all one": lambda values: np.full(values.shape, values.ravel()[0]),
}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("make", [make_mhr, make_soma])
@pytest.mark.parametrize("change", CHANGES)
def test_an_array_of_other_values_is_read_or_refused(make, change, tmp_path):
    """Broken where any values of an array are a traceback, or a body that has no finite place."""
    plain = make()
    person = {"identity_coeffs": np.ones(2)} | ({"model_parameters": np.full(204, 0.1)} if make is make_mhr else {})
    for name, values in (plain | person).items():
        if values.dtype.kind == "U" and change in ("not numbers", "infinite", "huge", "negative", "zeros"):
            continue
        try:
            body = load(tmp_path, plain | person | {name: CHANGES[change](values)})
        except (BodyModelBad, BodyModelUnsupported):
            continue
        for place in (body.vertices, body.rest_vertices, body.joints, body.rest_joints, body.transforms):
            assert np.isfinite(place).all(), name
