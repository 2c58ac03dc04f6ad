"""Read a body of MHR, the Momentum Human Rig, from an `.npz` file of the plain arrays of its model.

MHR (Ferguson et al. 2025, "MHR: Momentum Human Rig") is shipped as FBX and as a compiled program, neither of which is
opened here. Its arrays are saved by their names in that program: those of `character_torch.blend_shape`, `.mesh`,
`.skeleton`, `.linear_blend_skinning` and `.parameter_transform`. With n vertices and j joints, in centimetres, y up,
facing +z: `base_shape` [n, 3], `shape_vectors` [s, n, 3], `faces` [f, 3], `joint_names` [j], `joint_parents` [j],
`inverse_bind_pose` [j, 8] (translation, quaternion x y z w, scale), and of each influence `vert_indices_flattened`,
`skin_indices_flattened`, `skin_weights_flattened`. Of the person `identity_coeffs` [<= s] and, with
`joint_translation_offsets` [j, 3], `joint_prerotations` [j, 4] and `parameter_transform` [7 j, p],
`model_parameters` [204]; or both by the names that SAM 3D Body has, `shape_params` and `mhr_model_params`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ..body import Body
from ..model_arrays import (
    CENTIMETRE_LENGTH,
    BodyModelBad,
    check_indices,
    check_parents,
    check_shapes,
    check_vertex_count,
    check_weights,
    read_arrays,
)
from ..motion.joint_tree import JointTree
from .rigged import PosedMesh, RiggedMesh, keep_largest_part, make_body, reduce_rig

MHR_ARRAYS = (
    "base_shape", "shape_vectors", "faces", "joint_names", "joint_parents", "inverse_bind_pose",
    "vert_indices_flattened", "skin_indices_flattened", "skin_weights_flattened",
)  # fmt: skip
MHR_POSE_ARRAYS = ("joint_translation_offsets", "joint_prerotations", "parameter_transform")
MHR_PERSON_ARRAYS = ("identity_coeffs", "model_parameters")
SAM_NAMES = {"shape_params": "identity_coeffs", "mhr_model_params": "model_parameters"}
"""Names of a person's arrays in the output of SAM 3D Body, and those of MHR."""

MAX_BONE_SCALE = 4.0
"""Largest scale of a bone that is a person's, and inverse of the least [1]: a child's limbs are half an adult's."""

MHR_POSE_COUNT, MHR_PARAMETER_COUNT = 136, 204
"""Number of MHR's parameters of the pose, and of these and the scales of bones after them."""

JOINT_PARAMETER_COUNT = 7
"""Number of a joint's parameters: translation, turns about x, y and z, and the logarithm of its scale to base 2."""


def load_mhr(path: Path) -> Body:
    """Read a body with MHR's skeleton reduced to ours: nothing is registered.

    v = sum over joints j of w_j W_j B_j (b + sum of c_k s_k), W_j = W_parent [2^e P Rz Ry Rx | o + t], where t, the
    turns and e are the joint's rows of the parameter transform times the parameters.

    Notation: b base shape, s shape vectors, c identity; w weights, B inverse bind pose; o translation offset, P
    prerotation. Source: `skin_points` and `joint_parameters_to_skeleton_state` of Momentum.

    **Deviation**: pose correctives, a network in a file of its own, are left out.

    Raises:
        BodyModelBad: where an array is missing, has another shape or kind, or the body has no person's height.
    """
    found = read_arrays(path, MHR_ARRAYS, (*MHR_PERSON_ARRAYS, *SAM_NAMES, *MHR_POSE_ARRAYS))
    found |= {own: found[name] for name, own in SAM_NAMES.items() if name in found and own not in found}
    count, joint_count = len(found["base_shape"]), len(found["joint_parents"])
    check_vertex_count(count, path.name)
    influences = found["skin_weights_flattened"].shape
    shapes = {
        "base_shape": (count, 3), "shape_vectors": (-1, count, 3), "faces": (-1, 3), "joint_names": (joint_count,),
        "inverse_bind_pose": (joint_count, 8), "vert_indices_flattened": influences,
        "skin_indices_flattened": influences, "skin_weights_flattened": (-1,),
    }  # fmt: skip
    check_shapes(found, shapes, path.name)
    parents = check_parents(found["joint_parents"], "joint_parents")
    weights = np.zeros((count, joint_count))
    rows = check_indices(found["vert_indices_flattened"], count, "vert_indices_flattened")
    columns = check_indices(found["skin_indices_flattened"], joint_count, "skin_indices_flattened")
    np.add.at(weights, (rows, columns), found["skin_weights_flattened"])
    weights = check_weights(weights, path.name)
    coefficients = _person(found, "identity_coeffs", len(found["shape_vectors"]), path.name)
    shaped = found["base_shape"] + np.tensordot(coefficients, found["shape_vectors"][: len(coefficients)], axes=1)
    binds = _transforms(found["inverse_bind_pose"])
    standing = posed = np.linalg.inv(binds)
    parameters = {"identity_coeffs": coefficients}
    if "model_parameters" in found:
        values = _person(found, "model_parameters", MHR_PARAMETER_COUNT, path.name)
        values = np.concatenate([values, np.zeros(MHR_PARAMETER_COUNT - len(values))])
        scales = values * (np.arange(MHR_PARAMETER_COUNT) >= MHR_POSE_COUNT)
        standing, posed = (_pose_joints(found, parents, one, path.name) for one in (scales, values))
        parameters["model_parameters"] = values
    kept, faces = keep_largest_part(shaped, check_indices(found["faces"], count, "faces"))
    shaped, weights = shaped[kept], weights[kept]
    mesh = _skin(shaped, weights, standing @ binds)
    tree = JointTree(tuple(str(name) for name in found["joint_names"]), parents, CENTIMETRE_LENGTH * standing[:, :3, 3])
    reduced, source = reduce_rig(RiggedMesh(CENTIMETRE_LENGTH * mesh, faces, tree, weights))
    moves = (posed @ np.linalg.inv(standing))[source]
    moves[:, :3, 3] *= CENTIMETRE_LENGTH
    vertices = CENTIMETRE_LENGTH * _skin(shaped, weights, posed @ binds)
    return make_body(reduced, f"mhr:{path.stem}", PosedMesh(vertices, moves, parameters))


def _person(found: dict[str, np.ndarray], name: str, limit: int, file: str) -> np.ndarray:
    """Return the person's values of a name, at most `limit` of them; none where the file has none."""
    values = np.asarray(found.get(name, np.zeros(0)))
    if values.dtype.kind != "f" or values.size > limit or not np.isfinite(values).all():
        raise BodyModelBad(f"{file}: {name} are not at most {limit} numbers of one person.")
    return values.ravel()


def _transforms(states: np.ndarray) -> np.ndarray:
    """Return the homogeneous transforms [j, 4, 4] of translations, quaternions x y z w and scales, shape [j, 8]."""
    lengths = np.linalg.norm(states[:, 3:7], axis=1)
    if (lengths < 0.5).any() or (states[:, 7] < 1e-3).any():
        raise BodyModelBad(f"inverse_bind_pose has no rotations or scales. {BodyModelBad().message}")
    found = np.tile(np.eye(4), (len(states), 1, 1))
    found[:, :3, :3] = Rotation.from_quat(states[:, 3:7]).as_matrix() * states[:, 7, None, None]
    found[:, :3, 3] = states[:, :3]
    return found


def _pose_joints(found: dict[str, np.ndarray], parents: tuple[int, ...], values: np.ndarray, name: str) -> np.ndarray:
    """Compute the joints' transforms [j, 4, 4] to the model's space by MHR's parameters [204]."""
    count = len(parents)
    missing = [one for one in MHR_POSE_ARRAYS if one not in found]
    if missing:
        raise BodyModelBad(f"{name} has model_parameters, and lacks {', '.join(missing)}.")
    shapes = {
        "joint_translation_offsets": (count, 3), "joint_prerotations": (count, 4),
        "parameter_transform": (JOINT_PARAMETER_COUNT * count, -1),
    }  # fmt: skip
    check_shapes(found, shapes, name)
    matrix, turns = found["parameter_transform"], found["joint_prerotations"]
    if matrix.shape[1] < MHR_PARAMETER_COUNT or (np.linalg.norm(turns, axis=1) < 0.5).any():
        raise BodyModelBad(f"{name}: parameter_transform or joint_prerotations are not MHR's.")
    own = (matrix[:, :MHR_PARAMETER_COUNT] @ values).reshape(count, JOINT_PARAMETER_COUNT)
    local = np.tile(np.eye(4), (count, 1, 1))
    local[:, :3, :3] = (Rotation.from_quat(turns) * Rotation.from_euler("xyz", own[:, 3:6])).as_matrix()
    local[:, :3, :3] *= np.exp2(np.clip(own[:, 6], -9.0, 9.0))[:, None, None]  # what is beyond is refused below
    local[:, :3, 3] = own[:, :3] + found["joint_translation_offsets"]
    for joint, parent in enumerate(parents):
        if parent >= 0:
            local[joint] = local[parent] @ local[joint]
    scales = np.cbrt(np.abs(np.linalg.det(local[:, :3, :3])))
    if not np.isfinite(local).all() or scales.min() < 1.0 / MAX_BONE_SCALE or scales.max() > MAX_BONE_SCALE:
        raise BodyModelBad(f"{name}: model_parameters scale a bone by more than {MAX_BONE_SCALE:g}.")
    return local


def _skin(points: np.ndarray, weights: np.ndarray, transforms: np.ndarray) -> np.ndarray:
    blended = (weights @ transforms.reshape(len(transforms), 16)).reshape(-1, 4, 4)
    return np.asarray(np.einsum("nab,nb->na", blended[:, :3, :3], points) + blended[:, :3, 3])
