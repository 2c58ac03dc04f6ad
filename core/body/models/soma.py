"""Read a body of SOMA's model from `SOMA_neutral.npz` of SOMA-X 0.1, with a person's coefficients beside its arrays.

Of its arrays are read, with n vertices and j joints, in centimetres, y up, facing +z: `bind_shape` [n, 3], `triangles`
[f, 3], `joint_names` [j], `joint_parent_ids` [j], `bind_pose_world` [j, 4, 4], the skinning weights as a matrix [n, j]
in compressed columns, `skinning_weights_data`, `_indices`, `_indptr` and `_shape`; and with the person's
`identity_coeffs` [<= c] also `mean` [n, 3], `shapedirs` [c, 3 n] and `eigenvalues` [c].
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..body import Body
from ..model_arrays import (
    CENTIMETRE_LENGTH,
    BodyModelBad,
    BodyModelUnsupported,
    check_indices,
    check_parents,
    check_shapes,
    check_vertex_count,
    check_weights,
    list_arrays,
    read_arrays,
)
from ..motion.joint_tree import JointTree
from .rigged import PosedMesh, RiggedMesh, keep_largest_part, make_body, reduce_rig

SOMA_ARRAYS = (
    "bind_shape", "triangles", "joint_names", "joint_parent_ids", "bind_pose_world", "skinning_weights_data",
    "skinning_weights_indices", "skinning_weights_indptr", "skinning_weights_shape",
)  # fmt: skip
SOMA_SHAPE_ARRAYS = ("mean", "shapedirs", "eigenvalues")


def load_soma(path: Path) -> Body:
    """Read a body with SOMA's skeleton reduced to ours, standing as in SOMA's bind pose: nothing is registered.

    v = m + sum over k of c_k sqrt(e_k) s_k (`SOMAIdentityModel`), with mean m, shape directions s and eigenvalues e.

    **Deviation**: a joint moves with the mean displacement of the vertices that both it and its parent move, weighted
    by the product of both weights; SOMA interpolates it by radial basis functions.

    Raises:
        BodyModelBad: where an array is missing, has another shape or kind, or the body has no person's height.
        BodyModelUnsupported: where it has a pose.
    """
    if "poses" in list_arrays(path):
        raise BodyModelUnsupported(f"{path.name} has poses, which are not read; leave them out, and use --pose.")
    found = read_arrays(path, SOMA_ARRAYS, ("identity_coeffs", *SOMA_SHAPE_ARRAYS))
    count, joint_count = len(found["bind_shape"]), len(found["joint_parent_ids"])
    check_vertex_count(count, path.name)
    shapes = {
        "bind_shape": (count, 3), "triangles": (-1, 3), "joint_names": (joint_count,),
        "bind_pose_world": (joint_count, 4, 4), "skinning_weights_data": (-1,),
        "skinning_weights_indices": found["skinning_weights_data"].shape, "skinning_weights_indptr": (joint_count + 1,),
    }  # fmt: skip
    check_shapes(found, shapes, path.name)
    parents = check_parents(found["joint_parent_ids"], "joint_parent_ids")
    weights = _weights_of(found, count, joint_count, path.name)
    shaped, coefficients = _shape(found, count, path.name)
    moved = shaped - found["bind_shape"]
    shared = weights * weights[:, np.maximum(parents, 0)]
    shared = np.where(shared.sum(axis=0) > 0.0, shared, weights)
    places = found["bind_pose_world"][:, :3, 3] + (shared.T @ moved) / np.maximum(shared.sum(axis=0), 1e-12)[:, None]
    kept, faces = keep_largest_part(shaped, check_indices(found["triangles"], count, "triangles"))
    tree = JointTree(tuple(str(name) for name in found["joint_names"]), parents, CENTIMETRE_LENGTH * places)
    mesh, _ = reduce_rig(RiggedMesh(CENTIMETRE_LENGTH * shaped[kept], faces, tree, weights[kept]))
    return make_body(mesh, f"soma:{path.stem}", PosedMesh(mesh.vertices, parameters={"identity_coeffs": coefficients}))


def _weights_of(found: dict[str, np.ndarray], count: int, joint_count: int, name: str) -> np.ndarray:
    """Return the skinning weights [n, j] of a matrix in compressed columns."""
    ends = found["skinning_weights_indptr"]
    size = len(found["skinning_weights_data"])
    if (
        tuple(found["skinning_weights_shape"].ravel()) != (count, joint_count)
        or ends[0] != 0
        or ends[-1] != size
        or (np.diff(ends) < 0).any()
    ):
        raise BodyModelBad(f"{name}: skinning_weights are no matrix [{count}, {joint_count}] in compressed columns.")
    rows = check_indices(found["skinning_weights_indices"], count, "skinning_weights_indices")
    weights = np.zeros((count, joint_count))
    np.add.at(weights, (rows, np.repeat(np.arange(joint_count), np.diff(ends).astype(np.int64))),
              found["skinning_weights_data"])  # fmt: skip
    return check_weights(weights, name)


def _shape(found: dict[str, np.ndarray], count: int, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices of a person's coefficients, in SOMA's unit, and the coefficients."""
    coefficients = np.asarray(found.get("identity_coeffs", np.zeros(0)))
    if coefficients.dtype.kind != "f" or not np.isfinite(coefficients).all():
        raise BodyModelBad(f"{name}: identity_coeffs are no numbers.")
    coefficients = coefficients.ravel()
    if not len(coefficients):
        return found["bind_shape"], coefficients
    missing = [one for one in SOMA_SHAPE_ARRAYS if one not in found]
    if missing:
        raise BodyModelBad(f"{name} has identity_coeffs, and lacks {', '.join(missing)}.")
    spreads, directions = found["eigenvalues"].ravel(), found["shapedirs"]
    if (
        directions.size != len(spreads) * 3 * count
        or found["mean"].size != 3 * count
        or len(coefficients) > len(spreads)
        or not all(np.isfinite(found[one]).all() for one in SOMA_SHAPE_ARRAYS)
        or (spreads < 0.0).any()
    ):
        raise BodyModelBad(f"{name}: mean, shapedirs and eigenvalues do not go with {count} vertices.")
    used = len(coefficients)
    moves = (coefficients * np.sqrt(spreads[:used])) @ directions.reshape(len(spreads), 3 * count)[:used]
    return found["mean"].reshape(count, 3) + moves.reshape(count, 3), coefficients
