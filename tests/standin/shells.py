"""A person in a T-shirt over trousers, made of the built-in body: each point of the shell has its true label."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.people.part import Part
from garmentq.core.people.separation import LabelledPerson
from garmentq.core.scan.raw import RawScan
from scipy.spatial import cKDTree

BODY = "builtin:male,height=1.78,weight=75,pose=A"
SHIRT = ("spine1", "spine2", "spine3", "left_collar", "right_collar", "left_shoulder", "right_shoulder")
TROUSERS = ("pelvis", "left_hip", "right_hip", "left_knee", "right_knee")


@dataclass(frozen=True)
class Shells:
    """Describe a dressed person.

    Attributes:
        points: Positions [m], shape [n, 3].
        faces: Shape [f, 3].
        label: A `Part` for each point, shape [n].
        body: The wearer.
    """

    points: np.ndarray
    faces: np.ndarray
    label: np.ndarray
    body: Body


def dress_in_shells(rounds: int = 1) -> Shells:
    """Lift skin by 20 mm where the shirt is, and by 12 mm where the trousers are; `rounds` make the mesh finer."""
    body = builtin_body(BODY)
    part = np.array(JOINTS)[body.weights.argmax(axis=1)]
    coarse = np.full(len(part), int(Part.SKIN))
    coarse[np.isin(part, TROUSERS)], coarse[np.isin(part, SHIRT)] = Part.LOWER, Part.UPPER
    vertices, faces = body.vertices, body.faces
    for _ in range(rounds):
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    label = coarse[cKDTree(body.vertices).query(vertices)[1]]
    lift = np.select([label == Part.UPPER, label == Part.LOWER], [0.020, 0.012], 0.0)
    points = vertices + lift[:, None] * vertex_normals(vertices, faces)
    return Shells(points, faces, label.astype(np.uint8), body)


def separate_by_truth(shells: Shells, extra: int = 2) -> tuple[RawScan, LabelledPerson]:
    """Return what taking these shells apart would find if it found the truth; the file had `extra` points more."""
    count = len(shells.points)
    place = np.concatenate([np.full(extra, -1), np.arange(count)])
    origin = np.arange(extra, extra + count)
    raw = RawScan(shells.points, shells.faces, None, True, None, None, origin, place, name="shells")
    label = np.concatenate([np.full(extra, int(Part.OTHER)), shells.label]).astype(np.uint8)
    height = np.concatenate([np.ones(extra), shells.points[:, 1]])
    sure = 0.35 + 0.65 * np.abs(np.sin(8.0 * height))
    return raw, LabelledPerson(shells.body, label, sure, (), (), (), None)
