"""Read a body in SMPL's format from an `.npz` file: blend shapes, joint regressor, skinning. No pickle.

The format (Loper et al. 2015, "SMPL: a skinned multi-person linear model"), with N vertices and B shapes:
`v_template` [N, 3], `shapedirs` [N, 3, B], `posedirs` [N, 3, 207], `J_regressor` [24, N], `weights` [N, 24],
`kintree_table` [2, 24], `f` [F, 3]; and of the person, each optional, `betas` [<= B], `pose` [72] or [24, 3]
(axis-angle, rad) and `trans` [3] (m). The arrays are the user's own: no such file comes with garmentq.
SMPL-X, with 55 joints, is reduced to these (`smplx.py`).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..run.errors import BadInput
from .body import JOINT_PARENTS, Body
from .model_arrays import MAX_MODEL_VERTEX_COUNT, PERSON_HEIGHT_RANGE, read_arrays
from .skinning import skin
from .smplx import is_smplx, reduce_smplx
from .template import articulate, rotations_of, transforms_of

REQUIRED_ARRAYS = ("v_template", "shapedirs", "posedirs", "J_regressor", "weights", "kintree_table", "f")
PERSON_ARRAYS = ("betas", "pose", "trans")


class SmplBad(BadInput):
    """The file is not a body in SMPL's format; give an .npz of plain arrays as docs/reference/files.md lists them."""

    code = "body.smpl_bad"


def load_smpl(path: Path) -> Body:
    """Read a body with its own skeleton: nothing is registered, and the joints are the file's.

    T = v_template + shapedirs betas; J = J_regressor T; v = skin(T + posedirs (R(pose) - I), weights, J, pose) + trans.

    Notation: T the shaped template in its T-pose, `rest`; J its joints; R(pose) the rotations of the 23 joints below
    the root, row by row. Source: Loper et al. 2015, eq. 2 to 10.

    **Deviation**: `rest_vertices` leave out the pose blend shapes, which belong to the pose; so `skin` of the rest pose
    is up to a few centimetres from `vertices` at strongly bent joints. `fit_rms` is the mean of that.

    Args:
        path: The `.npz` file; y up, metres.

    Raises:
        SmplBad: where an array is missing, has another shape or kind, or the body has no person's height.
    """
    data = _check(read_arrays(Path(path), REQUIRED_ARRAYS, PERSON_ARRAYS, SmplBad), Path(path).name)
    rest = data["v_template"] + data["shapedirs"][:, :, : len(data["betas"])] @ data["betas"]
    joints = data["J_regressor"] @ rest
    rotations = rotations_of(data["pose"].reshape(24, 3))
    bent = rest + data["posedirs"] @ (rotations[1:] - np.eye(3)).ravel()
    floor = np.array([0.0, rest[:, 1].min(), 0.0])
    rest, joints, bent = rest - floor, joints - floor, bent - floor
    world, posed = articulate(rotations, joints, data["trans"] + floor)
    transforms = transforms_of(world, posed, joints)
    weights, faces = data["weights"], data["f"].astype(np.int64)
    vertices = skin(bent, weights, transforms)
    if not PERSON_HEIGHT_RANGE[0] <= float(np.ptp(rest[:, 1])) <= PERSON_HEIGHT_RANGE[1]:
        raise SmplBad(f"The body in {Path(path).name} is {np.ptp(rest[:, 1]):.2f} m high; give it in metres, y up.")
    front = world[0] @ np.array([0.0, 0.0, 1.0])
    yaw = np.arctan2(front[0], front[2])
    return Body(
        vertices=vertices,
        faces=faces,
        joints=posed,
        weights=weights,
        transforms=transforms,
        rest_vertices=rest,
        rest_faces=faces,
        rest_joints=joints,
        rest_weights=weights,
        heading=rotations_of(np.array([0.0, -yaw, 0.0])),
        parameters={"shape": data["betas"], "pose": data["pose"].reshape(24, 3), "translation": data["trans"] + floor},
        source=f"smpl:{Path(path).stem}",
        fit_rms=float(np.sqrt(((skin(rest, weights, transforms) - vertices) ** 2).sum(axis=1).mean())),
    )


def _check(found: dict[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    count = len(found["v_template"]) if found["v_template"].ndim == 2 else 0
    if is_smplx(found):
        found = reduce_smplx(found)
    found.setdefault("betas", np.zeros(0))
    found.setdefault("pose", np.zeros(72))
    found.setdefault("trans", np.zeros(3))
    for key in PERSON_ARRAYS:
        found[key] = found[key].ravel()
    shapes = {
        "v_template": (count, 3), "posedirs": (count, 3, 207), "J_regressor": (24, count), "weights": (count, 24),
        "kintree_table": (2, 24), "pose": (72,), "trans": (3,),
    }  # fmt: skip
    for key, shape in shapes.items():
        if found[key].shape != shape or not np.isfinite(found[key]).all():
            raise SmplBad(f"{name}: {key} has the shape {found[key].shape}, expected {shape}. {SmplBad().message}")
    directions, faces = found["shapedirs"], found["f"]
    if directions.ndim != 3 or directions.shape[:2] != (count, 3) or len(found["betas"]) > directions.shape[2]:
        raise SmplBad(f"{name}: shapedirs {directions.shape} do not go with betas {found['betas'].shape}.")
    if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces) or faces.min() < 0 or faces.max() >= count:
        raise SmplBad(f"{name}: f are no faces of {count} vertices. {SmplBad().message}")
    if (
        not 100 <= count <= MAX_MODEL_VERTEX_COUNT
        or not np.isfinite(directions).all()
        or not np.isfinite(found["betas"]).all()
    ):
        raise SmplBad(f"{name}: {count} vertices, or values that are no numbers. {SmplBad().message}")
    if not np.array_equal(found["kintree_table"][0, 1:].astype(np.int64), JOINT_PARENTS[1:]):
        raise SmplBad(f"{name}: kintree_table is not SMPL's 24 joints. {SmplBad().message}")
    total = found["weights"].sum(axis=1, keepdims=True)
    if (found["weights"] < -1e-6).any() or np.abs(total - 1.0).max() > 1e-2:
        raise SmplBad(f"{name}: the rows of weights do not sum to 1. {SmplBad().message}")
    return {**found, "weights": found["weights"] / total}
