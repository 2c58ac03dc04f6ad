"""A person in a random everyday pose, as a scanner sees one: other triangles than the model's, and noise."""

from __future__ import annotations

import igl
import numpy as np
import trimesh
from garmentq.core.body.body import JOINTS
from garmentq.core.body.skinning import skin
from garmentq.core.body.template import Template, articulate, rotations_of, transforms_of

NOISE = 2e-3
"""Noise of the mesh [m per coordinate]: a hand-held scanner's."""
FACES = 12000
"""Faces after the decimation: none of the model's edges is left where two meet."""
SHAPE = 0.8
"""Spread of the random shapes in standard deviations of the model: nearly all remain within its range."""


def everyday_body(template: Template, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Make a random person in a random everyday pose.

    Returns:
        Vertices [m], faces, true joints [m] of shape [24, 3], and the heading: the turn about y from facing z [rad].
    """
    rng = np.random.default_rng(seed)
    gender = ("female", "male")[seed % 2]
    count = template.shape_count
    root = np.linalg.cholesky(template.covariances[gender] + 1e-9 * np.eye(count))
    rest, joints = template.shaped(template.means[gender] + SHAPE * root @ rng.standard_normal(count))
    angles = np.zeros((24, 3))
    drop, stride, heading = rng.uniform(-0.2, 1.3), rng.uniform(-0.5, 0.5), rng.uniform(0, 2 * np.pi)
    angles[0] = (0, heading, 0)
    for side, sign in (("left", -1), ("right", 1)):
        shoulder = (rng.normal(0, 0.2), sign * rng.uniform(-0.2, 0.7), sign * (drop + rng.normal(0, 0.15)))
        angles[JOINTS.index(f"{side}_shoulder")] = shoulder
        angles[JOINTS.index(f"{side}_elbow")] = (0, sign * rng.uniform(0, 1.3), 0)
        angles[JOINTS.index(f"{side}_hip")] = (sign * stride, rng.normal(0, 0.1), -sign * rng.uniform(0, 0.15))
        angles[JOINTS.index(f"{side}_knee")] = (rng.uniform(0, 0.5), 0, 0)
    for name in ("spine1", "spine2", "spine3", "neck", "head"):
        angles[JOINTS.index(name)] = rng.normal(0, 0.08, 3)
    world, posed = articulate(rotations_of(angles), joints, rng.uniform(-1, 1, 3))
    skinned = skin(rest, template.weights, transforms_of(world, posed, joints))
    finer = trimesh.Trimesh(skinned, template.faces, process=False).subdivide()
    vertices, faces, *_ = igl.qslim(np.asfortranarray(finer.vertices), np.asfortranarray(finer.faces, np.int32), FACES)
    return vertices + rng.normal(0, NOISE, vertices.shape), faces, posed, heading
