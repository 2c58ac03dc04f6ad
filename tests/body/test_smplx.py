"""Bodies of SMPL-X's format, from a small made-up file: reduced to SMPL's joints, they are posed as all 55 would."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.smpl import SmplBad, load_smpl
from garmentq.core.body.smplx import SMPLX_PARENTS
from garmentq.core.body.template import load_template
from scipy.spatial.transform import Rotation

TEMPLATE = load_template()
COUNT = len(TEMPLATE.vertices)


def make_arrays() -> dict[str, np.ndarray]:
    """Return a made-up model with SMPL-X's 55 joints on the built-in body's surface, and a bent person."""
    rng = np.random.default_rng(4)
    weights, regressor = np.zeros((COUNT, 55)), np.zeros((55, COUNT))
    weights[:, :22] = TEMPLATE.weights[:, :22]
    for hand, first in ((22, 25), (23, 40)):
        weights[:, first : first + 15] = TEMPLATE.weights[:, hand, None] * rng.dirichlet(np.ones(15), COUNT)
    face = 0.3 * weights[:, 15]
    weights[:, 15] -= face
    weights[:, 22] = face
    places = np.concatenate([TEMPLATE.joints[:22], np.repeat(TEMPLATE.joints[[15, 22, 23]], (3, 15, 15), axis=0)])
    for joint, place in enumerate(places + rng.normal(0.0, 0.01, places.shape)):
        near = np.argsort(np.linalg.norm(TEMPLATE.vertices - place, axis=1))[:40]
        regressor[joint, near] = 1.0 / len(near)
    pose = np.zeros((55, 3))
    pose[0], pose[18], pose[15], pose[20] = (0, 0.6, 0), (0, -0.7, 0), (0.2, 0, 0), (0, 0, 0.4)
    return {
        "v_template": TEMPLATE.vertices, "shapedirs": np.moveaxis(TEMPLATE.directions[:10], 0, 2),
        "posedirs": 1e-3 * rng.standard_normal((COUNT, 3, 486)), "J_regressor": regressor, "weights": weights,
        "kintree_table": np.array([[2**32 - 1, *SMPLX_PARENTS[1:]], range(55)], dtype=np.uint32),
        "f": TEMPLATE.faces.astype(np.uint32), "betas": rng.standard_normal(10), "pose": pose.ravel(),
        "trans": np.array([0.3, 0.1, -0.2]),
    }  # fmt: skip


def pose_all_joints(data: dict[str, np.ndarray]) -> np.ndarray:
    """Return the vertices by the paper's equations with all 55 joints."""
    shaped = data["v_template"] + data["shapedirs"] @ data["betas"]
    joints = data["J_regressor"] @ shaped
    turns = Rotation.from_rotvec(data["pose"].reshape(-1, 3)).as_matrix()
    bent = shaped + data["posedirs"] @ (turns[1:] - np.eye(3)).ravel()
    found, world = np.zeros_like(bent), []
    for joint, parent in enumerate(SMPLX_PARENTS):
        own = np.eye(4)
        own[:3, :3], own[:3, 3] = turns[joint], joints[joint] - (joints[parent] if joint else 0.0)
        world.append(world[parent] @ own if joint else own)
        found += data["weights"][:, joint, None] * ((bent - joints[joint]) @ world[-1][:3, :3].T + world[-1][:3, 3])
    return found + data["trans"]


def test_a_file_is_posed_as_with_all_its_joints(tmp_path):
    """Broken where a weight of hands or face goes to another joint, or pose blend shapes are numbered otherwise."""
    data = make_arrays()
    np.savez(tmp_path / "x.npz", **data)
    body = load_smpl(tmp_path / "x.npz")
    assert np.abs(body.vertices - pose_all_joints(data)).max() < 1e-9
    assert body.weights.shape == (COUNT, 24) and body.weights.sum(axis=1) == pytest.approx(np.ones(COUNT))
    np.savez(tmp_path / "y.npz", **(data | {"pose": data["pose"][:66]}))
    assert load_smpl(tmp_path / "y.npz").vertices == pytest.approx(body.vertices)


@pytest.mark.parametrize("name", ["weights", "posedirs", "J_regressor"])
def test_a_file_with_other_arrays_is_refused(tmp_path, name):
    """Broken where an array of another size is cut to fit."""
    data = make_arrays()
    data[name] = data[name][..., :-1]
    np.savez(tmp_path / "x.npz", **data)
    with pytest.raises(SmplBad):
        load_smpl(tmp_path / "x.npz")
