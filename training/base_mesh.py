"""Bring accessories that were made on the MakeHuman base mesh onto the built-in body, which was made from it, too."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import igl
import numpy as np

from ..core.body.body import Body
from ..core.body.registration import register_body
from ..core.body.skinning import skin, unskin
from ..core.body.template import load_template

Mesh = tuple[np.ndarray, np.ndarray]
"""Vertices [m], shape [n, 3], and faces, shape [m, 3]."""

DECIMETRE = 0.1
"""Metres per unit of the base mesh."""


@dataclass(frozen=True)
class BaseMesh:
    """The base mesh and the built-in body that was fitted to its skin.

    Attributes:
        vertices: All vertices, helpers included [m], shape [19158, 3].
        body: The built-in body as the base mesh stands.
    """

    vertices: np.ndarray
    body: Body


def read_base_mesh(path: Path) -> BaseMesh:
    """Read the base mesh and fit the built-in body to its skin, the group `body`."""
    vertices, groups = read_obj(path)
    outer = np.concatenate([faces for name, faces in groups if name == "body"])
    used, index = np.unique(outer, return_inverse=True)
    vertices = DECIMETRE * vertices
    return BaseMesh(vertices, register_body(vertices[used], index.reshape(-1, 3)))


def read_obj(path: Path) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """Read an OBJ's vertices [n, 3] and its triangles by group; polygons are cut into fans."""
    vertices: list[list[float]] = []
    groups: dict[str, list[list[int]]] = {}
    name = ""
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append([float(word) for word in words[1:4]])
        elif words[0] == "g":
            name = words[1] if len(words) > 1 else ""
        elif words[0] == "f":
            corner = [int(word.split("/")[0]) - 1 for word in words[1:]]
            groups.setdefault(name, []).extend([corner[0], a, b] for a, b in pairwise(corner[1:]))
    return np.array(vertices), [(name, np.array(faces)) for name, faces in groups.items()]


def read_worn(folder: Path, name: str, base: BaseMesh) -> Mesh:
    """Read a mesh with its ties to the base mesh and put it around the built-in body's mean in its T-pose [m].

    A vertex lies at the weighted mean of three vertices of the base mesh plus an offset, which scales with the distance
    of two of its vertices along each axis (MakeHuman's `.mhclo`). From there it goes with the nearest skin.
    """
    own, groups = read_obj(folder / f"{name}.obj")
    tied = _tie(folder / f"{name}.mhclo", base.vertices)
    if len(tied) != len(own):
        raise ValueError(f"{name}.mhclo ties {len(tied)} of {len(own)} vertices")
    body = base.body
    to_mean = load_template().vertices - body.rest_vertices
    model = skin(body.rest_vertices, body.rest_weights, body.transforms)
    both = surface_values(model, body.rest_faces, np.hstack([body.rest_weights, to_mean]), tied)
    rest = unskin(tied, both[:, :24], body.transforms) + both[:, 24:]
    return rest, np.concatenate([faces for _, faces in groups])


def surface_values(vertices: np.ndarray, faces: np.ndarray, values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return values of the nearest place of a surface for each point, shape [n, ...]; `values` are its vertices'."""
    _, face, nearest = igl.point_mesh_squared_distance(points, vertices, faces)
    corner = faces[face]
    share = igl.barycentric_coordinates(nearest, *(np.ascontiguousarray(vertices[corner[:, k]]) for k in range(3)))
    share = np.clip(np.nan_to_num(share, nan=1 / 3), 0.0, 1.0)
    return np.einsum("nk,nk...->n...", share / share.sum(axis=1, keepdims=True), values[corner])


def _tie(path: Path, base: np.ndarray) -> np.ndarray:
    """Return where a `.mhclo` puts its vertices on the base mesh [m], shape [n, 3]."""
    scale, rows, reading = np.full(3, DECIMETRE), [], False
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] in ("x_scale", "y_scale", "z_scale"):
            axis = "xyz".index(words[0][0])
            scale[axis] = abs(base[int(words[1]), axis] - base[int(words[2]), axis]) / float(words[3])
        elif words[0] == "verts":
            reading = True
        elif reading and words[0].lstrip("-").isdigit():
            rows.append([float(word) for word in words] if len(words) == 9 else [float(words[0])] * 3 + [1, 0, 0] * 2)
        elif reading and rows:
            break
    table = np.array(rows)
    alone = table[:, 3:6].sum(axis=1) < 0.5
    share = table[:, 3:6]
    offset = np.where(alone[:, None], 0.0, table[:, 6:9])
    return np.einsum("nk,nka->na", share, base[table[:, :3].astype(int)]) + scale * offset
