"""The wearer's mesh in any pose of its skeleton."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..body import Body
from ..skinning import skin, unskin
from .track import Pose


@dataclass(frozen=True)
class MovingBody:
    """Pose a wearer's own mesh by linear blend skinning; the wearer's own pose gives that mesh to round-off."""

    body: Body

    @cached_property
    def at_rest(self) -> np.ndarray:
        """Return the wearer's own mesh mapped back to the T-pose [m], shape [vertex_count, 3]."""
        return unskin(self.body.vertices, self.body.weights, self.body.transforms)

    def transforms(self, pose: Pose) -> np.ndarray:
        """Return the transforms from rest space to a pose, shape [24, 4, 4]."""
        return pose.transforms(self.body.rest_joints)

    def vertices(self, pose: Pose) -> np.ndarray:
        """Return the mesh in a pose [m], shape [vertex_count, 3]."""
        return skin(self.at_rest, self.body.weights, self.transforms(pose))

    def posed(self, pose: Pose) -> Body:
        """Return the wearer in a pose."""
        transforms = self.transforms(pose)
        joints = np.einsum("jab,jb->ja", transforms[:, :3, :3], self.body.rest_joints) + transforms[:, :3, 3]
        return replace(self.body, vertices=self.vertices(pose), joints=joints, transforms=transforms)
