"""The bodies of Anny, by its own parameters and exactly: phenotypes and pose in, vertices and joints out.

Anny (Bregier et al. 2025, "Human mesh modeling for Anny body") sums MakeHuman's targets (CC0), weighted by phenotypes
from 0 to 1, and poses bones by linear blend skinning. The asset has all targets of its phenotypes from one year of age,
on its outer skin; local changes and facial actions are not in it. Anny's axes are z up, facing -y; its files' units
are metres.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ..body import JOINTS, Body
from .rigged import PosedMesh, StandingMesh, make_body

ANNY_ASSET = Path(__file__).parents[1] / "assets" / "anny.npz"

SHAPE_UNIT = 1e-4
"""Unit of the stored blend shapes [m]."""

PHENOTYPES = {
    "gender": (0.0, 1.0), "age": (0.0, 1.0), "muscle": (0.0, 1.0), "weight": (0.0, 1.0), "height": (0.0, 1.0),
    "proportions": (0.0, 1.0), "cupsize": (0.0, 1.0), "firmness": (0.0, 1.0), "african": (0.0, 1.0),
    "asian": (0.0, 1.0), "caucasian": (0.0, 1.0),
}  # fmt: skip
"""Anny's phenotypes with their range [1]. Gender 0 is male; age 0 is one year, 1/3 a child, 2/3 young, 1 old."""

USUAL_PHENOTYPE = 0.5
"""What Anny takes for a phenotype that is not given [1]."""

ANCHORS: Mapping[str, tuple[tuple[str, float], ...]] = {
    "gender": (("male", 0.0), ("female", 1.0)),
    "age": (("baby", 0.0), ("child", 1 / 3), ("young", 2 / 3), ("old", 1.0)),
    "muscle": (("minmuscle", 0.0), ("averagemuscle", 0.5), ("maxmuscle", 1.0)),
    "weight": (("minweight", 0.0), ("averageweight", 0.5), ("maxweight", 1.0)),
    "height": (("minheight", 0.0), ("maxheight", 1.0)),
    "proportions": (("idealproportions", 0.0), ("uncommonproportions", 1.0)),
    "cupsize": (("mincup", 0.0), ("averagecup", 0.5), ("maxcup", 1.0)),
    "firmness": (("minfirmness", 0.0), ("averagefirmness", 0.5), ("maxfirmness", 1.0)),
}
"""The words of MakeHuman's targets, with the phenotype's value at which each counts in full [1]."""

ANCESTRIES = ("african", "asian", "caucasian")
"""The phenotypes of which only the shares of their sum count."""

JOINT_BONES = {
    "pelvis": "root", "left_hip": "upperleg01.L", "right_hip": "upperleg01.R", "spine1": "spine04",
    "left_knee": "lowerleg01.L", "right_knee": "lowerleg01.R", "spine2": "spine03", "left_ankle": "foot.L",
    "right_ankle": "foot.R", "spine3": "spine02", "left_foot": "toe2-1.L", "right_foot": "toe2-1.R",
    "neck": "neck01", "left_collar": "clavicle.L", "right_collar": "clavicle.R", "head": "head",
    "left_shoulder": "upperarm01.L", "right_shoulder": "upperarm01.R", "left_elbow": "lowerarm01.L",
    "right_elbow": "lowerarm01.R", "left_wrist": "wrist.L", "right_wrist": "wrist.R", "left_hand": "finger3-1.L",
    "right_hand": "finger3-1.R",
}  # fmt: skip
"""The bone whose head is each joint of `JOINTS`."""


@dataclass(frozen=True)
class AnnyPerson:
    """Describe a person by Anny's parameters.

    Attributes:
        phenotypes: Values of `PHENOTYPES` [1], in their order, shape [11].
        pose: Transforms of the bones in Anny's parameterization `local-ref` [m], in the rig's order, shape
            [bone_count, 4, 4]; None: identities, which are Anny's reference pose.
    """

    phenotypes: np.ndarray
    pose: np.ndarray | None = None


@dataclass(frozen=True)
class AnnyModel:
    """Describe Anny's data on its outer skin; axes are Anny's.

    Attributes:
        words: Words of targets, in the columns of `masks`.
        masks: Which words each target is of, shape [target_count, word_count].
        shape_of: Index of each target's blend shape, shape [target_count].
        shapes: Blend shapes in `SHAPE_UNIT`, whole numbers, shape [shape_count, 3, n].
        head_shapes, turn_shapes: The same of heads [m] and orientations, shapes [shape_count, b, 3], [.., b, 3, 3].
        template, template_heads, template_turns: What they are added to, shapes [n, 3], [b, 3], [b, 3, 3].
        reference_turns: Orientation of each bone in the reference pose, shape [b, 3, 3].
        bones: Names of the bones.
        parents: Index of each bone's parent; the root, which is the first, has -1.
        weights, weight_bones: Skinning weights and their bones, shape [n, k].
        vertex_numbers: The vertices' numbers in Anny's mesh, shape [n].
        faces: Outward faces of the closed skin, shape [f, 3]; vertices from n on are the rims' centroids.
        rims: Sum over each rim's vertices, divided by their number, as a matrix [rim_count, n].
    """

    words: tuple[str, ...]
    masks: np.ndarray
    shape_of: np.ndarray
    shapes: np.ndarray
    head_shapes: np.ndarray
    turn_shapes: np.ndarray
    template: np.ndarray
    template_heads: np.ndarray
    template_turns: np.ndarray
    reference_turns: np.ndarray
    bones: tuple[str, ...]
    parents: tuple[int, ...]
    weights: np.ndarray
    weight_bones: np.ndarray
    vertex_numbers: np.ndarray
    faces: np.ndarray
    rims: np.ndarray


@cache
def load_anny_model(path: Path = ANNY_ASSET) -> AnnyModel:
    """Read Anny's data from its file."""
    with np.load(path) as data:
        found = {name: data[name] for name in data.files}
    ends = np.cumsum(found.pop("rim_lengths"))
    vertices = found.pop("rim_vertices")
    rims = np.zeros((len(ends), len(found["template"])))
    for row, rim in zip(rims, np.split(vertices, ends[:-1]), strict=True):
        row[rim] = 1.0 / len(rim)
    weights = found["weights"].astype(np.float64)
    return AnnyModel(
        **{name: values for name, values in found.items() if name not in ("words", "bones", "parents", "weights")},
        words=tuple(str(word) for word in found["words"]),
        bones=tuple(str(bone) for bone in found["bones"]),
        parents=tuple(int(parent) for parent in found["parents"]),
        weights=weights / weights.sum(axis=1, keepdims=True),
        rims=rims,
    )


def make_anny_body(person: AnnyPerson, source: str = "anny:") -> Body:
    """Return the body of Anny's parameters: its vertices are those that Anny computes, in our axes.

    The T-pose is that of Anny's rest pose (`make_body`).

    Raises:
        BodyModelBad: where it is smaller than the smallest person that is read.
    """
    model = load_anny_model()
    share = shape_weights(model, person.phenotypes)
    used = np.flatnonzero(share)
    moves = np.tensordot(share[used], model.shapes[used].astype(np.float64), axes=1)
    rest = model.template + SHAPE_UNIT * moves.T
    heads = model.template_heads + np.tensordot(share, model.head_shapes.astype(np.float64), axes=1)
    turns = _nearest_rotations(model.template_turns + np.tensordot(share, model.turn_shapes.astype(np.float64), axes=1))
    bones = _bone_transforms(model, heads, turns, person.pose)
    columns = np.array([model.bones.index(bone) for bone in JOINT_BONES.values()])
    blended = np.einsum("nk,nkab->nab", model.weights, bones[model.weight_bones])
    posed = np.einsum("nab,nb->na", blended[:, :3, :3], rest) + blended[:, :3, 3]
    own = np.eye(4)
    own[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    standing = StandingMesh(
        _close(model, rest) @ own[:3, :3].T,
        model.faces.astype(np.int64),
        heads[columns] @ own[:3, :3].T,
        _joint_weights(model),
    )
    kept = {"phenotypes": person.phenotypes} | ({} if person.pose is None else {"pose_parameters": person.pose})
    return make_body(
        standing, source, PosedMesh(_close(model, posed) @ own[:3, :3].T, own @ bones[columns] @ own.T, kept)
    )


def shape_weights(model: AnnyModel, phenotypes: np.ndarray) -> np.ndarray:
    """Compute the weight of each blend shape: that of a target is the product of its words', and a word's falls
    linearly from 1 at its anchor to 0 at the next ones; ancestries are shares of their sum.

    Args:
        model: Anny's data.
        phenotypes: Values of `PHENOTYPES`, shape [11].

    Returns:
        Weights [1], shape [shape_count].
    """
    value = dict(zip(PHENOTYPES, phenotypes, strict=True))
    of_word = dict.fromkeys(model.words, 0.0)
    for name, anchors in ANCHORS.items():
        places = [place for _, place in anchors]
        for at, (word, _) in enumerate(anchors):
            of_word[word] = float(np.interp(value[name], places, np.eye(len(anchors))[at]))
    total = sum(value[name] for name in ANCESTRIES)
    for name in ANCESTRIES:
        of_word[name] = value[name] / total if total > 0.0 else 1 / 3
    factors = np.where(model.masks, [of_word[word] for word in model.words], 1.0)
    return np.bincount(model.shape_of, factors.prod(axis=1), minlength=len(model.shapes))


def local_ref_of(model: AnnyModel, transforms: np.ndarray) -> np.ndarray:
    """Return a pose in Anny's parameterization `local-ref` for one in `local-bone`, whose transforms are in the axes of
    each bone's reference pose, shape [b, 4, 4]."""
    frames = np.tile(np.eye(4), (len(model.bones), 1, 1))
    frames[:, :3, :3] = model.reference_turns
    return np.asarray(frames @ transforms @ np.swapaxes(frames, 1, 2))


def _bone_transforms(model: AnnyModel, heads: np.ndarray, turns: np.ndarray, pose: np.ndarray | None) -> np.ndarray:
    """Compute the transforms [b, 4, 4] of the bones from the rest pose to the pose, in Anny's axes.

    W_c = W_p [U_p' | 0] [D_c U_c | d_c + A_p (h_c - h_p)] and T_c = W_c [R_c | h_c]^-1, with A_p = U_p R_p', but I at
    the root, and W_0 = [U_0' D_0 U_0 | U_0' d_0].

    Notation: bone c with parent p; R, h orientation and head at rest; U orientation in the reference pose; [D | d] the
    pose's; ' the transpose. Source: `forward_kinematic` of Anny 0.6, parameterization `local-ref`.
    """
    reference = model.reference_turns
    pose = np.tile(np.eye(4), (len(model.bones), 1, 1)) if pose is None else pose
    to_reference = reference @ np.swapaxes(turns, 1, 2)
    to_reference[0] = np.eye(3)
    world, found = np.zeros((len(model.bones), 4, 4)), np.tile(np.eye(4), (len(model.bones), 1, 1))
    for bone, parent in enumerate(model.parents):
        own, shift = pose[bone, :3, :3] @ reference[bone], pose[bone, :3, 3]
        above = np.eye(4) if parent < 0 else world[parent]
        frame = reference[max(parent, 0)].T
        if parent >= 0:
            shift = shift + to_reference[parent] @ (heads[bone] - heads[parent])
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = frame @ own, frame @ shift
        world[bone] = above @ step
        found[bone, :3, :3] = world[bone, :3, :3] @ turns[bone].T
        found[bone, :3, 3] = world[bone, :3, 3] - found[bone, :3, :3] @ heads[bone]
    return found


def _nearest_rotations(matrices: np.ndarray) -> np.ndarray:
    """Return the rotations [b, 3, 3] that are nearest to matrices (orthogonal Procrustes, determinant 1)."""
    left, _, right = np.linalg.svd(matrices)
    left[:, :, 2] *= np.linalg.det(left @ right)[:, None]
    return np.asarray(left @ right)


def _close(model: AnnyModel, vertices: np.ndarray) -> np.ndarray:
    return np.concatenate([vertices, model.rims @ vertices])


def _joint_weights(model: AnnyModel) -> np.ndarray:
    """Return the closed skin's weights of `JOINTS`: each bone counts for its nearest ancestor that is one."""
    joint_of = {bone: JOINTS.index(joint) for joint, bone in JOINT_BONES.items()}
    ours = np.zeros(len(model.bones), dtype=np.int64)
    for at, bone in enumerate(model.bones):
        ours[at] = joint_of.get(bone, ours[max(model.parents[at], 0)])
    weights = np.zeros((len(model.weights), 24))
    for column, bones in zip(model.weights.T, model.weight_bones.T, strict=True):
        np.add.at(weights, (np.arange(len(weights)), ours[bones]), column)
    return _close(model, weights)
