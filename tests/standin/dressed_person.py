"""A dressed person put together from the built-in body: clothes as offsets, skirts and coats as cones, hair and shoes.

No drape: what it is for is whether the body below is found, and that needs folds less than it needs gaps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from garmentq.core.body.body import JOINTS
from garmentq.core.body.presence import find_hair_vertices
from garmentq.core.body.skinning import skin
from garmentq.core.body.template import Template, articulate, rotations_of, transforms_of
from garmentq.core.geometry.geometry import vertex_normals

SKIN, HAIR, SHOES, UPPER, LOWER, ONE_PIECE, OUTER = 0, 1, 2, 10, 11, 12, 13

STANCES: dict[str, dict[str, tuple[float, float, float]]] = {
    "T": {},
    "A": {"left_shoulder": (0, 0, -0.7), "right_shoulder": (0, 0, 0.7)},
    "down": {"left_shoulder": (0, 0, -1.2), "right_shoulder": (0, 0, 1.2)},
    "stride": {
        "left_hip": (-0.4, 0, 0), "right_hip": (0.3, 0, 0), "right_knee": (0.3, 0, 0),
        "left_shoulder": (0, 0, -1.0), "right_shoulder": (0, 0, 1.0), "left_elbow": (0, -0.4, 0),
    },
    "arms up": {"left_shoulder": (0, 0, 1.1), "right_shoulder": (0, 0, -1.1), "left_elbow": (0, -0.3, 0)},
    "goalpost": {
        "left_shoulder": (-1.3, 0, 0), "right_shoulder": (-1.3, 0, 0), "left_elbow": (0, -1.4, 0),
        "right_elbow": (0, 1.4, 0),
    },
    "hips": {
        "left_shoulder": (0.8, 0.2, -0.8), "right_shoulder": (0.8, -0.2, 0.8), "left_elbow": (0, -1.6, 0),
        "right_elbow": (0, 1.6, 0),
    },
    "leg raised": {
        "left_hip": (-1.3, 0, 0), "left_knee": (1.3, 0, 0), "left_shoulder": (0, 0, -0.9),
        "right_shoulder": (0, 0, 0.9),
    },
}  # fmt: skip
"""Poses as axis-angles [rad], not quite those that the search starts from."""

OUTFITS: dict[str, dict[str, float]] = {
    "bare": {},
    "tee and shorts": {"sleeve": 0.6, "top": 0.012, "leg": 0.7, "bottom": 0.020},
    "tight": {"sleeve": 1.9, "top": 0.003, "leg": 1.8, "bottom": 0.003},
    "shirt and trousers": {"sleeve": 1.8, "top": 0.018, "leg": 1.8, "bottom": 0.025},
    "skirt": {"sleeve": 0.6, "top": 0.010, "flare": 0.25, "hem": 0.55},
    "flared skirt": {"sleeve": 0.4, "top": 0.006, "flare": 0.60, "hem": 0.45},
    "coat": {"sleeve": 1.9, "top": 0.035, "leg": 1.8, "bottom": 0.015, "flare": 0.12, "hem": 0.40},
}
"""What is worn: sleeves and legs as stations (1 elbow or knee, 2 wrist or ankle), ease of top and bottom [m], and of a
skirt or coat the flare (radius per height) and the hem's height over the body's."""


@dataclass(frozen=True)
class Dressed:
    """A dressed person.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        faces: Shape [f, 3].
        label: Of each vertex, shape [n].
        body: Vertices of the true body [m], shape [m, 3]; its faces are the template's.
        covered: Label of what covers each vertex of the true body, 0 where bare, shape [m].
        joints: True joints [m], shape [24, 3].
        heading: Turn about y from facing z [rad].
    """

    vertices: np.ndarray
    faces: np.ndarray
    label: np.ndarray
    body: np.ndarray
    covered: np.ndarray
    joints: np.ndarray
    heading: float


def dress_person(template: Template, seed: int, stance: str = "A", outfit: str = "tee and shorts") -> Dressed:
    """Make a person of a random shape and heading, in a stance and an outfit by name, with hair and shoes."""
    rng = np.random.default_rng(seed)
    worn = OUTFITS[outfit]
    gender = ("female", "male")[seed % 2]
    root = np.linalg.cholesky(template.covariances[gender] + 1e-9 * np.eye(template.shape_count))
    shape = template.means[gender] + 0.7 * root @ rng.standard_normal(template.shape_count)
    rest, joints = template.shaped(shape)
    angles = rng.normal(0, 0.06, (24, 3)) * (np.arange(24) > 0)[:, None]
    for joint, vector in STANCES[stance].items():
        angles[JOINTS.index(joint)] += vector
    heading = float(rng.uniform(0, 2 * np.pi))
    angles[0] = (0.0, heading, 0.0)
    world, posed = articulate(rotations_of(angles), joints, rng.uniform(-0.5, 0.5, 3))
    transforms = transforms_of(world, posed, joints)
    body = skin(rest, template.weights, transforms)
    label, offset = _clothe(template, rest, joints, worn, rng)
    # A hand's breadth of folds: low waves of a third of the ease.
    phase = sum(np.sin(rest @ rng.normal(0, 40, 3) + rng.uniform(0, 6)) for _ in range(4)) / 4
    offset = offset * np.where(label >= UPPER, 1.0 + 0.35 * phase, 1.0)
    scan = body + offset[:, None] * vertex_normals(body, template.faces)
    vertices, faces, marks = scan, template.faces, label
    covered = np.where(label >= UPPER, label, np.where(label > 0, label, 0))
    if "flare" in worn:
        part = OUTER if "leg" in worn else LOWER
        cone, cone_faces, inside = _hang(scan, posed, world[0], worn, heading)
        covered = np.where(inside & (covered == 0), part, covered)
        faces = faces[~inside[faces].all(axis=1)]
        vertices = np.vstack([scan, cone])
        faces = np.vstack([faces, cone_faces + len(scan)])
        marks = np.concatenate([label, np.full(len(cone), part)])
    finer = trimesh.Trimesh(vertices, faces, process=False).subdivide()
    seen = np.unique(finer.faces)
    place = np.full(len(finer.vertices), -1)
    place[seen] = np.arange(len(seen))
    points = finer.vertices[seen] + rng.normal(0, 1.5e-3, (len(seen), 3))
    marks = _nearest_label(points, vertices, marks)
    return Dressed(points, place[finer.faces], marks, body, covered, posed, heading)


def _clothe(
    template: Template, rest: np.ndarray, joints: np.ndarray, worn: dict[str, float], rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Label the body's vertices and say how far out [m] what covers them lies, by their place in the T-pose."""
    label, offset = np.zeros(len(rest), int), np.zeros(len(rest))
    normals = vertex_normals(rest, template.faces)
    at = {name: joints[JOINTS.index(name)] for name in JOINTS}
    arm = np.interp(np.abs(rest[:, 0]), [0, at["left_shoulder"][0], at["left_elbow"][0], at["left_wrist"][0], 2.0],
                    [-1, 0, 1, 2, 3])  # fmt: skip
    leg = np.interp(-rest[:, 1], [-2.0, -at["left_hip"][1], -at["left_knee"][1], -at["left_ankle"][1], 1.0],
                    [-1, 0, 1, 2, 3])  # fmt: skip
    waist, neck = at["spine1"][1], at["neck"][1] - 0.02
    if "leg" in worn:
        mine = (leg < worn["leg"]) & (rest[:, 1] < waist) & (arm < 0.6)
        label[mine], offset[mine] = LOWER, worn["bottom"] * np.clip(0.35 + 0.5 * leg[mine] + 0.5, 0.3, 1.2)
    if "sleeve" in worn:
        long = 0.12 if "leg" in worn else 0.0
        mine = (arm < worn["sleeve"]) & (rest[:, 1] > waist - long) & (rest[:, 1] < neck)
        # A top rests on the shoulders and the upper back, and hangs from there.
        lies = np.clip(normals[mine, 1], 0, 1)
        label[mine], offset[mine] = UPPER, 0.002 + worn["top"] * (1 - lies)
    shoes = template.weights[:, [JOINTS.index(f"{s}_{p}") for s in ("left", "right") for p in ("ankle", "foot")]]
    mine = (shoes.sum(axis=1) > 0.6) & (label == 0)
    label[mine], offset[mine] = SHOES, np.where(normals[mine, 1] < -0.7, 0.02, 0.006)
    hairy = find_hair_vertices(template)
    label[hairy], offset[hairy] = HAIR, rng.uniform(0.008, 0.03)
    return label, offset


def _hang(
    scan: np.ndarray, joints: np.ndarray, pelvis: np.ndarray, worn: dict[str, float], heading: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Hang a cone from the waist: its vertices [m], faces, and which of the scan's vertices it hides."""
    high = joints[JOINTS.index("spine1"), 1]
    low = scan[:, 1].min() + worn["hem"]
    axis = joints[0]
    turn = rotations_of(np.array([0.0, -heading, 0.0]))
    local = (scan - axis) @ turn.T
    angle = np.arctan2(local[:, 0], local[:, 2])
    radius = np.hypot(local[:, 0], local[:, 2])
    # Arms hang beside the skirt, not in it: what is more than a hip's breadth out is no part of what it rests on.
    trunk = radius < 0.30
    count, rows = 96, 40
    columns = np.linspace(-np.pi, np.pi, count, endpoint=False)
    heights = np.linspace(high, low, rows)
    table = np.zeros((rows, count))
    for j, column in enumerate(columns):
        near = trunk & (np.abs(np.angle(np.exp(1j * (angle - column)))) < 0.15)
        for i, height in enumerate(heights):
            slab = near & (np.abs(scan[:, 1] - height) < 0.02)
            least = radius[slab].max() + 0.004 if slab.any() else 0.0
            below = table[i - 1, j] + worn["flare"] * (heights[i - 1] - height) * (0.7 + 0.3 * np.sin(9 * column))
            table[i, j] = max(least, below if i else 0.10)
    local = np.stack([table * np.sin(columns), (heights - axis[1])[:, None] * np.ones(count), table * np.cos(columns)])
    cone = local.reshape(3, -1).T @ turn + axis
    i, j = np.divmod(np.arange((rows - 1) * count), count)
    a, b, c, d = i * count + j, i * count + (j + 1) % count, (i + 1) * count + j, (i + 1) * count + (j + 1) % count
    faces = np.vstack([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    row = np.clip(((high - scan[:, 1]) / (high - low) * (rows - 1)).round().astype(int), 0, rows - 1)
    column = ((angle + np.pi) / (2 * np.pi) * count).round().astype(int) % count
    inside = trunk & (scan[:, 1] < high) & (scan[:, 1] > low - 0.02) & (radius < table[row, column])
    return cone, faces, inside


def _nearest_label(points: np.ndarray, vertices: np.ndarray, label: np.ndarray) -> np.ndarray:
    from scipy.spatial import cKDTree

    return np.asarray(label[cKDTree(vertices).query(points)[1]])
