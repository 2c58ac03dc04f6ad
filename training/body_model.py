"""The built-in body in torch: shape and pose in, vertices and joints out, differentiable in both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from ..core.body.body import JOINT_PARENTS
from ..core.body.template import Template, load_template


@dataclass(frozen=True)
class PosedBody:
    """Describe a posed body: vertices [n, 3] and joints [24, 3] in metres, transforms from rest space [24, 4, 4]."""

    vertices: torch.Tensor
    joints: torch.Tensor
    transforms: torch.Tensor


class BodyModel:
    """Pose the built-in body by linear blend skinning, in float64.

    The T-pose vertices are `template + sum_k shape_k directions_k`, the joints likewise; each vertex then moves by the
    weighted mean of its joints' rigid transforms. No pose-dependent correctives.
    """

    def __init__(self, template: Template | None = None) -> None:
        """Take a template, or load the built-in one."""
        self.template = template or load_template()
        t = self.template
        self._vertices, self._joints = torch.from_numpy(t.vertices), torch.from_numpy(t.joints)
        self._directions = torch.from_numpy(t.directions)
        self._joint_directions = torch.from_numpy(t.joint_directions)
        self._weights = torch.from_numpy(t.weights)

    @property
    def faces(self) -> np.ndarray:
        """Return the outward faces, shape [f, 3]."""
        return self.template.faces

    def rest(self, shape: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return T-pose vertices [n, 3] and joints [24, 3] in metres of a shape [k] (standard deviations)."""
        k = len(shape)
        vertices = self._vertices + torch.tensordot(shape, self._directions[:k], dims=1)
        return vertices, self._joints + torch.tensordot(shape, self._joint_directions[:k], dims=1)

    def pose(self, shape: torch.Tensor, pose: torch.Tensor, translation: torch.Tensor | None = None) -> PosedBody:
        """Pose a shape.

        Args:
            shape: Shape coefficients in standard deviations, shape [k].
            pose: Axis-angle of each joint relative to its parent [rad], zeros are the T-pose, shape [24, 3].
            translation: Shift of the pelvis from its T-pose place [m], shape [3]; none is zero.
        """
        rest, joints = self.rest(shape)
        local = rotation_matrices(pose)
        world: list[torch.Tensor] = []
        posed: list[torch.Tensor] = []
        for j, parent in enumerate(JOINT_PARENTS):
            if parent < 0:
                world.append(local[j])
                posed.append(joints[j] if translation is None else joints[j] + translation)
            else:
                world.append(world[parent] @ local[j])
                posed.append(posed[parent] + world[parent] @ (joints[j] - joints[parent]))
        turn, place = torch.stack(world), torch.stack(posed)
        shift = place - (turn @ joints[:, :, None])[:, :, 0]
        blended = torch.tensordot(self._weights, torch.cat([turn, shift[:, :, None]], dim=2), dims=1)
        vertices = (blended[:, :, :3] @ rest[:, :, None])[:, :, 0] + blended[:, :, 3]
        last = torch.tensor([0.0, 0.0, 0.0, 1.0], dtype=turn.dtype).expand(24, 1, 4)
        return PosedBody(vertices, place, torch.cat([torch.cat([turn, shift[:, :, None]], dim=2), last], dim=1))


def rotation_matrices(vectors: torch.Tensor) -> torch.Tensor:
    """Return rotations [n, 3, 3] of axis-angle vectors [n, 3] (Rodrigues), differentiable at zero too."""
    zero = torch.zeros_like(vectors[:, 0])
    x, y, z = vectors.unbind(1)
    k = torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], dim=1).reshape(-1, 3, 3)
    # The square root has no derivative at 0; the shift by 1e-30 keeps it finite and changes no digit elsewhere.
    angle = torch.sqrt((vectors**2).sum(dim=1) + 1e-30)[:, None, None]
    first, second = torch.sinc(angle / torch.pi), 0.5 * torch.sinc(angle / (2 * torch.pi)) ** 2
    return torch.eye(3, dtype=vectors.dtype) + first * k + second * (k @ k)
