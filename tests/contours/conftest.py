"""Garments cut out of the built-in body's own skin, and tubes hung around it."""

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.geometry import vertex_normals

TOP = ("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar")
UPPER_ARMS = ("left_shoulder", "right_shoulder")
FOREARMS = ("left_elbow", "right_elbow")
SEAT = ("pelvis", "spine1", "left_hip", "right_hip")
SHINS = ("left_knee", "right_knee")
SKINS = {
    "tshirt": (TOP + UPPER_ARMS, True),
    "long_sleeve_tshirt": (TOP + UPPER_ARMS + FOREARMS, True),
    "tank": (TOP, True),
    "shorts": (SEAT, False),
    "trousers": (SEAT + SHINS, False),
    "jumpsuit": (TOP + UPPER_ARMS + SEAT + SHINS, False),
}


def compact(vertices, faces):
    """Drop unused vertices."""
    used, index = np.unique(faces, return_inverse=True)
    return vertices[used], index.reshape(-1, 3)


def cut_skin(body, kind):
    """Cut a garment out of the body's skin (by the joint that moves it most) and lift it 1 cm off."""
    parts, above_crotch = SKINS[kind]
    keep = np.isin(np.array(JOINTS)[body.weights.argmax(axis=1)], parts)
    if above_crotch:
        keep &= body.rest_vertices[:, 1] > body.rest_joints[JOINTS.index("left_hip"), 1]
    lifted = body.vertices + 0.01 * vertex_normals(body.vertices, body.faces)
    return compact(lifted, body.faces[keep[body.faces].all(axis=1)])


def open_skin(body, kind, width):
    """Cut a garment out of the body's skin without a strip of some width [m] along its centre front."""
    vertices, faces = cut_skin(body, kind)
    rest, rest_faces = cut_skin(replace(body, vertices=body.rest_vertices), kind)
    centres = rest[rest_faces].mean(axis=1) - body.rest_joints[JOINTS.index("spine2")]
    return compact(vertices, faces[(np.abs(centres[:, 0]) > width / 2) | (centres[:, 2] < 0.0)])


def hang_tube(body, top, bottom, around=48, rows=20, wave=0.0):
    """Hang a flared tube around the trunk between two heights given as shares of the body's height."""
    low, high = body.vertices[:, 1].min(), body.vertices[:, 1].max()
    angle = 2 * np.pi * np.arange(around) / around
    share = np.linspace(0.0, 1.0, rows)
    radius = 0.34 - 0.17 * share[:, None] + wave * (1 - share[:, None]) * np.cos(8 * angle)
    y = low + (high - low) * (bottom + (top - bottom) * share)
    middle = body.joint("pelvis")
    vertices = np.stack(
        [
            middle[0] + radius * np.sin(angle),
            np.repeat(y[:, None], around, axis=1),
            middle[2] + radius * np.cos(angle),
        ],
        axis=-1,
    ).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    return vertices, np.stack([a, b, b + around, a, b + around, a + around], axis=-1).reshape(-1, 3)


@pytest.fixture(scope="session")
def wearers():
    """Return the built-in body in three poses."""
    return {
        "T": builtin_body("builtin:female,height=1.70,pose=T"),
        "A": builtin_body("builtin:male,height=1.82,pose=A"),
        "arms-down": builtin_body("builtin:female,height=1.60,pose=arms-down"),
    }


@pytest.fixture(scope="session")
def skin():
    """Return the maker of garments cut out of a body's skin."""
    return cut_skin


@pytest.fixture(scope="session")
def hung():
    """Return the maker of tubes around the trunk."""
    return hang_tube


@pytest.fixture(scope="session")
def opened():
    """Return the maker of garments cut out of a body's skin that are open in front."""
    return open_skin
