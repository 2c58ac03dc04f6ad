"""Reduce a body in SMPL-X's format to SMPL's 24 joints: fingers and face stay as the model has them at rest.

SMPL-X (Pavlakos et al. 2019, "Expressive body capture") has 55 joints: SMPL's first 22, the jaw and two eyes below the
head, and 15 of each hand below its wrist. At rest these move with the joint above them, so that their skinning weights
can be added to its own: `skin` is then the same to rounding.
"""

from __future__ import annotations

import numpy as np

SMPLX_PARENTS = (
    -1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 15, 15, 15,
    20, 25, 26, 20, 28, 29, 20, 31, 32, 20, 34, 35, 20, 37, 38,
    21, 40, 41, 21, 43, 44, 21, 46, 47, 21, 49, 50, 21, 52, 53,
)  # fmt: skip
"""Index of each joint's parent in SMPL-X; the root's is -1."""

SMPLX_JOINT_COUNT = len(SMPLX_PARENTS)

SHARED_JOINT_COUNT = 22
"""Number of joints that SMPL and SMPL-X share: from the pelvis to the wrists."""

HEAD_JOINT = 15
"""Index of the head's joint."""

FACE_JOINTS, HAND_JOINTS = slice(22, 25), (slice(25, 40), slice(40, 55))
"""Indices of the joints of jaw and eyes, and of the left and the right hand."""

KNUCKLE_JOINTS = ((25, 28, 31, 34), (40, 43, 46, 49))
"""Indices of the first joints of index, middle, little and ring finger, left and right: their mean is SMPL's hand."""

POSE_VALUES_PER_JOINT = 9
"""Number of entries of a joint's rotation, by which pose blend shapes are numbered."""


def is_smplx(found: dict[str, np.ndarray]) -> bool:
    """Check whether arrays have SMPL-X's joints and kinematic tree."""
    tree = found["kintree_table"]
    return tree.shape == (2, SMPLX_JOINT_COUNT) and np.array_equal(tree[0, 1:].astype(np.int64), SMPLX_PARENTS[1:])


def reduce_smplx(found: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return arrays of SMPL's format for those of SMPL-X's.

    Args:
        found: `J_regressor` [55, N], `weights` [N, 55], `posedirs` [N, 3, 486] and the others of SMPL's format; `pose`,
            if there, of 55 or 22 joints. Turns of fingers, jaw and eyes are left out.
    """
    count = len(found["v_template"])
    shapes = {
        "J_regressor": (SMPLX_JOINT_COUNT, count),
        "weights": (count, SMPLX_JOINT_COUNT),
        "posedirs": (count, 3, POSE_VALUES_PER_JOINT * (SMPLX_JOINT_COUNT - 1)),
    }
    if any(found[name].shape != shape for name, shape in shapes.items()):
        return found  # the caller names what is wrong
    weights, regressor = found["weights"], found["J_regressor"]
    body = weights[:, :SHARED_JOINT_COUNT].copy()
    body[:, HEAD_JOINT] += weights[:, FACE_JOINTS].sum(axis=1)
    hands = [weights[:, hand].sum(axis=1) for hand in HAND_JOINTS]
    directions = found["posedirs"][:, :, : POSE_VALUES_PER_JOINT * (SHARED_JOINT_COUNT - 1)]
    unmoved = np.zeros((count, 3, 2 * POSE_VALUES_PER_JOINT))
    reduced = found | {
        "weights": np.column_stack([body, *hands]),
        "J_regressor": np.concatenate(
            [
                regressor[:SHARED_JOINT_COUNT],
                *(regressor[list(one)].mean(axis=0, keepdims=True) for one in KNUCKLE_JOINTS),
            ]
        ),
        "posedirs": np.concatenate([directions, unmoved], axis=2),
        "kintree_table": np.array([[-1, *SMPLX_PARENTS[1:SHARED_JOINT_COUNT], 20, 21], range(24)], dtype=np.float64),
    }
    if "pose" in found:
        turns = found["pose"].ravel()
        if len(turns) in (3 * SMPLX_JOINT_COUNT, 3 * SHARED_JOINT_COUNT):
            reduced["pose"] = np.concatenate([turns[: 3 * SHARED_JOINT_COUNT], np.zeros(6)])
    return reduced
