"""The built-in body's data and its articulation: shape and pose in, joints, transforms and vertices out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .body import JOINT_PARENTS

ASSET = Path(__file__).parent / "assets" / "builtin.npz"


@dataclass(frozen=True)
class Template:
    """Describe the built-in body in its T-pose, y up, facing +z, the left hand towards +x.

    Attributes:
        vertices: Mean vertices [m], shape [n, 3].
        faces: Outward faces, shape [f, 3].
        directions: Change of the vertices per standard deviation of each shape coefficient [m], shape [k, n, 3].
        joints: Mean joints [m], order of `JOINTS`, shape [24, 3].
        joint_directions: Change of the joints per coefficient [m], shape [k, 24, 3].
        weights: Skinning weights, rows sum to 1, shape [n, 24].
        means: Mean coefficients of `female` and `male`, shape [k] each.
        covariances: Covariances of the coefficients of `female` and `male`, shape [k, k] each.
    """

    vertices: np.ndarray
    faces: np.ndarray
    directions: np.ndarray
    joints: np.ndarray
    joint_directions: np.ndarray
    weights: np.ndarray
    means: dict[str, np.ndarray]
    covariances: dict[str, np.ndarray]

    @property
    def shape_count(self) -> int:
        """Return the number of shape coefficients."""
        return len(self.directions)

    def shaped(self, shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return T-pose vertices [n, 3] and joints [24, 3] of a shape [m]; trailing coefficients may be omitted."""
        k = len(shape)
        vertices = self.vertices + np.tensordot(shape, self.directions[:k], axes=1)
        return vertices, self.joints + np.tensordot(shape, self.joint_directions[:k], axes=1)


def load_template(path: Path = ASSET) -> Template:
    """Read the built-in body from its file."""
    with np.load(path) as data:
        weights = data["weights"].astype(np.float64)
        return Template(
            vertices=data["template"].astype(np.float64),
            faces=data["faces"].astype(np.int64),
            directions=data["directions"].astype(np.float64),
            joints=data["joints"].astype(np.float64),
            joint_directions=data["joint_directions"].astype(np.float64),
            weights=weights / weights.sum(axis=1, keepdims=True),
            means={name: data[f"{name}_mean"] for name in ("female", "male")},
            covariances={name: data[f"{name}_covariance"] for name in ("female", "male")},
        )


def rotations_of(vectors: np.ndarray) -> np.ndarray:
    """Return rotations [..., 3, 3] of axis-angle vectors [rad], shape [..., 3] (Rodrigues)."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    k = cross_matrices(vectors)
    # np.sinc(x) is sin(pi x) / (pi x), so both factors stay finite at angle 0.
    first, second = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    found: np.ndarray = np.eye(3) + first * k + second * (k @ k)
    return found


def cross_matrices(vectors: np.ndarray) -> np.ndarray:
    """Return the matrices [..., 3, 3] of the cross product with vectors [..., 3] on the left."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*vectors.shape[:-1], 3, 3)


def articulate(rotations: np.ndarray, joints: np.ndarray, translation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Chain local joint rotations down the skeleton.

    Args:
        rotations: Rotation of each joint relative to its parent; identities are the T-pose. Shape [24, 3, 3].
        joints: T-pose joints [m], shape [24, 3].
        translation: Shift of the pelvis from its T-pose place [m], shape [3].

    Returns:
        World rotations [24, 3, 3] and posed joints [m], [24, 3].
    """
    world, posed = np.zeros((24, 3, 3)), np.zeros((24, 3))
    for j, parent in enumerate(JOINT_PARENTS):
        if parent < 0:
            world[j], posed[j] = rotations[j], joints[j] + translation
        else:
            world[j] = world[parent] @ rotations[j]
            posed[j] = posed[parent] + world[parent] @ (joints[j] - joints[parent])
    return world, posed


def transforms_of(world: np.ndarray, posed: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Return the homogeneous transforms [24, 4, 4] from rest space to the pose."""
    transforms = np.tile(np.eye(4), (24, 1, 1))
    transforms[:, :3, :3] = world
    transforms[:, :3, 3] = posed - np.einsum("jab,jb->ja", world, joints)
    return transforms
