"""Bodies of SMPL's format, from a file that the test writes."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body.body import JOINT_PARENTS, JOINTS
from garmentq.core.body.smpl import SmplBad, load_smpl
from garmentq.core.body.template import load_template
from garmentq.core.recover.inputs import read_files
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.wearer import find_body
from scipy.spatial.transform import Rotation

TEMPLATE = load_template()


def arrays(seed: int = 0) -> dict[str, np.ndarray]:
    """Return a model of SMPL's format with the built-in body's surface, and a person bent at the elbows."""
    rng = np.random.default_rng(seed)
    count = len(TEMPLATE.vertices)
    regressor = np.zeros((24, count))
    for j, joint in enumerate(TEMPLATE.joints):
        near = np.argsort(np.linalg.norm(TEMPLATE.vertices - joint, axis=1))[:60]
        regressor[j, near] = 1.0 / len(near)
    pose = np.zeros((24, 3))
    pose[0], pose[JOINTS.index("left_elbow")], pose[JOINTS.index("right_hip")] = (0, 0.6, 0), (0, -0.7, 0), (-0.3, 0, 0)
    return {
        "v_template": TEMPLATE.vertices,
        "shapedirs": np.moveaxis(TEMPLATE.directions[:10], 0, 2),
        "posedirs": 1e-3 * rng.standard_normal((count, 3, 207)),
        "J_regressor": regressor,
        "weights": TEMPLATE.weights,
        "kintree_table": np.array([[2**32 - 1, *JOINT_PARENTS[1:]], range(24)], dtype=np.uint32),
        "f": TEMPLATE.faces.astype(np.uint32),
        "betas": rng.standard_normal(10),
        "pose": pose.ravel(),
        "trans": np.array([0.3, 0.1, -0.2]),
    }


def pose_slowly(data: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and joints by the paper's equations, joint by joint with homogeneous matrices."""
    shaped = data["v_template"] + np.einsum("nkb,b->nk", data["shapedirs"], data["betas"])
    joints = data["J_regressor"] @ shaped
    turns = Rotation.from_rotvec(data["pose"].reshape(24, 3)).as_matrix()
    bent = shaped + np.einsum("nkp,p->nk", data["posedirs"], (turns[1:] - np.eye(3)).reshape(-1))
    world = []
    for j, parent in enumerate(JOINT_PARENTS):
        own = np.eye(4)
        own[:3, :3], own[:3, 3] = turns[j], joints[j] - (joints[parent] if j else 0)
        world.append(world[parent] @ own if j else own)
    posed = np.array([g[:3, 3] for g in world])
    vertices = np.zeros_like(bent)
    for j, g in enumerate(world):
        vertices += data["weights"][:, j : j + 1] * ((bent - joints[j]) @ g[:3, :3].T + g[:3, 3])
    return vertices + data["trans"], posed + data["trans"]


def write(path: Path, **changes: np.ndarray | None) -> Path:
    """Write the file, with some arrays changed or left out."""
    data = {name: value for name, value in (arrays() | changes).items() if value is not None}
    np.savez(path, **data)
    return path


def test_a_smpl_file_is_posed_as_the_paper_says(tmp_path: Path) -> None:
    """Broken where blend shapes, the order of joints or the translation are applied otherwise than in the format."""
    body = load_smpl(write(tmp_path / "anna.npz"))
    vertices, joints = pose_slowly(arrays())
    assert np.allclose(body.vertices, vertices, atol=1e-9)
    assert np.allclose(body.joints, joints, atol=1e-9)
    assert body.source == "smpl:anna" and body.rest_vertices[:, 1].min() == pytest.approx(0.0, abs=1e-12)
    carried = np.einsum("jab,jb->ja", body.transforms, np.c_[body.rest_joints, np.ones(24)])[:, :3]
    assert np.allclose(carried, joints, atol=1e-9)
    front = body.heading @ [np.sin(0.6), 0, np.cos(0.6)]
    assert np.allclose(front, [0, 0, 1], atol=1e-9)


def test_a_smpl_file_is_a_body_of_a_recovery(tmp_path: Path) -> None:
    """Broken where the file is parsed as a mesh, registered instead of read, or the garment is not placed on it."""
    path = write(tmp_path / "anna.npz")
    body = load_smpl(path)
    part = np.isin(body.weights.argmax(axis=1), [JOINTS.index(n) for n in ("spine1", "spine2", "spine3")])
    faces = body.faces[part[body.faces].all(axis=1)]
    shell = trimesh.Trimesh(100 * body.vertices, faces, process=False)
    shell.remove_unreferenced_vertices()
    shell.export(tmp_path / "top.ply")
    request = Request(scan=tmp_path / "top.ply", body=path)
    pieces = read_files(request)
    assert pieces.garment.units == "cm"
    found = find_body(request, pieces, None)
    assert np.array_equal(found.joints, body.joints)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"weights": None}, "weights"),
        ({"v_template": 100 * TEMPLATE.vertices, "betas": None}, "high"),
        ({"J_regressor": np.zeros((24, 5))}, "J_regressor"),
        ({"J_regressor": np.array({"sparse": 1}, dtype=object)}, "dense"),
        ({"kintree_table": np.zeros((2, 24), dtype=np.int64)}, "kintree_table"),
        ({"f": TEMPLATE.faces + 1}, "faces"),
        ({"pose": np.full(72, np.nan)}, "pose"),
        ({"pose": np.zeros(69)}, "pose"),
    ],
)
def test_what_is_no_such_body_is_refused(tmp_path: Path, changes: dict, word: str) -> None:
    """Broken where a pickle is opened, or a wrong array becomes a wrong body or a traceback."""
    with pytest.raises(SmplBad, match=word) as caught:
        load_smpl(write(tmp_path / "bad.npz", **changes))
    assert caught.value.code == "body.smpl_bad"


def test_a_file_that_is_no_archive_is_refused(tmp_path: Path) -> None:
    """Broken where garbage ends in a traceback."""
    (tmp_path / "x.npz").write_bytes(b"no archive")
    with pytest.raises(SmplBad):
        load_smpl(tmp_path / "x.npz")
    with pytest.raises(SmplBad):
        load_smpl(tmp_path / "missing.npz")
