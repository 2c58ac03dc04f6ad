"""The wearer: a mesh with a skeleton, posed as the scan is."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..geometry.geometry import vertex_normals

__all__ = ["Body"]

JOINTS = (
    "pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2", "left_ankle", "right_ankle",
    "spine3", "left_foot", "right_foot", "neck", "left_collar", "right_collar", "head", "left_shoulder",
    "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist", "left_hand", "right_hand",
)  # fmt: skip
"""SMPL's 24 joints in SMPL's order."""

JOINT_PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21)
"""Index of each joint's parent in `JOINTS`; the root's is -1. A bone is named by its child joint."""


DRESS_FORM_SOURCE = "form:"
"""Begin of the `source` of dress forms."""


@dataclass(frozen=True)
class Body:
    """Describe a body mesh with joints, bones and skinning weights, all in the scan's pose and place.

    Attributes:
        vertices: Positions [m], shape [vertex_count, 3]: the given mesh's; of a dressed person, the fitted model's.
        faces: Outward faces, shape [face_count, 3].
        joints: Joint positions in this pose [m], order of `JOINTS`, shape [24, 3].
        weights: Linear blend skinning weights of `vertices`, rows sum to 1, shape [vertex_count, 24].
        transforms: From rest (T-pose) space to this pose, per joint, homogeneous, shape [24, 4, 4].
        rest_vertices: The fitted model in its T-pose, feet at y = 0, facing +z, shape [model_count, 3].
        rest_faces: Faces of the fitted model, shape [model_face_count, 3].
        rest_joints: Joints of the fitted model in its T-pose [m], shape [24, 3].
        rest_weights: Skinning weights of the fitted model, shape [model_count, 24].
        heading: Rotation [3, 3] from the file's axes to a body that faces +z.
        parameters: Shape and pose parameters of the fitted model by name.
        source: `builtin:female`, `mesh:NAME`, `form:NAME` (a dress form), `scan:NAME` (of a dressed person), or a body
            model's, `smpl:NAME`, `anny:NAME`, `mhr:NAME`, `soma:NAME`.
        fit_rms: RMS distance of the fitted model to the given mesh, or to a dressed person's skin [m]; 0 if built in.
    """

    vertices: np.ndarray
    faces: np.ndarray
    joints: np.ndarray
    weights: np.ndarray
    transforms: np.ndarray
    rest_vertices: np.ndarray
    rest_faces: np.ndarray
    rest_joints: np.ndarray
    rest_weights: np.ndarray
    heading: np.ndarray
    parameters: dict[str, np.ndarray] = field(default_factory=dict)
    source: str = ""
    fit_rms: float = 0.0

    def __repr__(self) -> str:
        """Return a one-line summary without the arrays."""
        return f"<Body {self.source}: {len(self.vertices)} vertices, {len(self.faces)} faces>"

    @property
    def is_dress_form(self) -> bool:
        """Return whether it is a dress form, of which only the trunk is there."""
        return self.source.startswith(DRESS_FORM_SOURCE)

    def joint(self, name: str) -> np.ndarray:
        """Return the position [m] of a named joint, shape [3]."""
        found: np.ndarray = self.joints[JOINTS.index(name)]
        return found

    def sideways(self, joints: str) -> np.ndarray:
        """Return the level vector [m] from the right one of two joints, `shoulder` or `hip`, to the left, shape [3]."""
        return np.asarray((self.joint(f"left_{joints}") - self.joint(f"right_{joints}")) * (1.0, 0.0, 1.0))

    def raised(self, heights: np.ndarray) -> Body:
        """Return the body with its vertices moved outward along their normals by heights [m], shape [vertex_count].
        Where the mesh is the fitted model's own (a person estimated under cloth), the T-pose is raised alike."""
        out = self.vertices + heights[:, None] * vertex_normals(self.vertices, self.faces)
        if len(self.rest_vertices) != len(self.vertices):
            return replace(self, vertices=out)
        rest = self.rest_vertices + heights[:, None] * vertex_normals(self.rest_vertices, self.rest_faces)
        return replace(self, vertices=out, rest_vertices=rest)
