"""Damage a target as scanners and exporters do, to measure for `garmentq bench --damage` how robust a recovery is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...core.geometry.geometry import face_areas

Mesh = tuple[np.ndarray, np.ndarray]

HOLE_RADII = (0.02, 0.05)
"""Radii of holes [m]: the occlusion at an armpit, and the largest patch that a hand or a lock of hair hides."""
OUTLIER_DISTANCE = 0.05
"""Distance of an outlier from its original position [m], in a random direction. Points further away form separate
pieces, which every scanner's software drops."""
HEM_CUT_HEIGHT = 0.08
"""Height by which a hem is cut off [m]."""
HEM_CUT_SLOPE = 0.1
"""Slope of the plane that cuts off a hem [m/m]: a scanner's frame is not level."""


@dataclass(frozen=True)
class Damage:
    """Describe one kind of damage.

    Attributes:
        name: Stable name, `noise_5mm`.
        text: Description, for a table.
        apply: From positions [m], faces and a generator to the damaged mesh.
        moves_body: True if the file of the wearer's body is changed too: units and axes apply to the whole scene.
    """

    name: str
    text: str
    apply: Callable[[np.ndarray, np.ndarray, np.random.Generator], Mesh]
    moves_body: bool = False


def add_noise(deviation: float) -> Callable[[np.ndarray, np.ndarray, np.random.Generator], Mesh]:
    """Move every vertex by Gaussian noise of a deviation [m] in each coordinate (thesis 4.3.4)."""

    def apply(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Mesh:
        return vertices + rng.normal(0.0, deviation, vertices.shape), faces

    return apply


def cut_holes(share: float) -> Callable[[np.ndarray, np.ndarray, np.random.Generator], Mesh]:
    """Remove the faces within balls around random places, until a share of the area is gone."""

    def apply(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Mesh:
        area, centres = face_areas(vertices, faces), vertices[faces].mean(axis=1)
        is_kept = np.ones(len(faces), bool)
        while area[~is_kept].sum() < share * area.sum():
            place = centres[rng.choice(len(faces), p=area / area.sum())]
            is_kept &= np.linalg.norm(centres - place, axis=1) > rng.uniform(*HOLE_RADII)
        return vertices, faces[is_kept]

    return apply


def add_outliers(share: float) -> Callable[[np.ndarray, np.ndarray, np.random.Generator], Mesh]:
    """Move a share of the vertices by `OUTLIER_DISTANCE` in random directions."""

    def apply(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Mesh:
        moved = rng.random(len(vertices)) < share
        direction = rng.standard_normal((int(moved.sum()), 3))
        vertices = vertices.copy()
        vertices[moved] += OUTLIER_DISTANCE * direction / np.linalg.norm(direction, axis=1, keepdims=True)
        return vertices, faces

    return apply


def flip_faces(share: float) -> Callable[[np.ndarray, np.ndarray, np.random.Generator], Mesh]:
    """Flip a share of the faces, drawn one by one; 1 flips all."""

    def apply(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Mesh:
        turned = rng.random(len(faces)) < share
        return vertices, np.where(turned[:, None], faces[:, ::-1], faces)

    return apply


def cut_hem(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Mesh:
    """Remove the faces below a randomly turned plane of slope `HEM_CUT_SLOPE`, `HEM_CUT_HEIGHT` above the
    lowest point.
    """
    side = rng.uniform(0.0, 2.0 * np.pi)
    middle = vertices.mean(axis=0)
    lean = HEM_CUT_SLOPE * ((vertices[:, 0] - middle[0]) * np.cos(side) + (vertices[:, 2] - middle[2]) * np.sin(side))
    above = vertices[:, 1] - vertices[:, 1].min() - lean > HEM_CUT_HEIGHT
    return vertices, faces[above[faces].any(axis=1)]


def to_centimetres(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Mesh:
    """Return the coordinates in centimetres."""
    return 100.0 * vertices, faces


def to_z_up(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Mesh:
    """Return the coordinates with z up: (x, y, z) becomes (x, -z, y)."""
    return np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1), faces


DAMAGES = (
    Damage("clean", "nothing", lambda vertices, faces, rng: (vertices, faces)),
    Damage("noise_5mm", "Gaussian noise of 5 mm in every coordinate", add_noise(0.005)),
    Damage("noise_10mm", "Gaussian noise of 10 mm in every coordinate", add_noise(0.010)),
    Damage("holes_5", "5 % of the area lost in holes of 2 to 5 cm radius", cut_holes(0.05)),
    Damage("holes_10", "10 % of the area lost in holes of 2 to 5 cm radius", cut_holes(0.10)),
    Damage("outliers_3", "3 % of the vertices moved by 5 cm", add_outliers(0.03)),
    Damage("flipped_all", "all faces flipped", flip_faces(1.0)),
    Damage("flipped_30", "30 % of the faces flipped at random", flip_faces(0.3)),
    Damage("hem_cut", "the lowest 8 cm cut off along a sloping plane", cut_hem),
    Damage("cm", "numbers in centimetres", to_centimetres, moves_body=True),
    Damage("z_up", "z axis up", to_z_up, moves_body=True),
)
"""Every kind of damage of the study; the first is none."""
