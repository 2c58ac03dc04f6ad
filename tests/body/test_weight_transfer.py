"""A mesh takes its weights from the skin of the same part, not from what is nearer."""

from __future__ import annotations

import numpy as np
from garmentq.core.body.weight_transfer import transfer_weights


def legs(offset, count=24, rings=12):
    """Return two upright cylinders of radius 8 cm whose axes stand `offset` [m] from the middle."""
    angle = 2 * np.pi * np.arange(count) / count
    ring = 0.08 * np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
    tube = (ring[None] + 0.04 * np.arange(rings)[:, None, None] * [0, 1, 0]).reshape(-1, 3)
    low = (count * np.arange(rings - 1)[:, None] + np.arange(count)).ravel()
    beside = (count * np.arange(rings - 1)[:, None] + (np.arange(count) + 1) % count).ravel()
    faces = np.concatenate(
        [np.stack([low, low + count, beside], 1), np.stack([beside, low + count, beside + count], 1)]
    )
    vertices = np.concatenate([tube + [offset, 0, 0], tube - [offset, 0, 0]])
    return vertices, np.concatenate([faces, faces + len(tube)]), len(tube)


def test_thighs_that_touch_keep_their_own_weights():
    """Broken where the inside of a thigh takes the weights of the other one, which the model has nearer there."""
    model, faces, half = legs(0.0805)
    mesh, _, _ = legs(0.077)  # 3.5 mm nearer: both insides lie within the model's other leg
    own = np.zeros((2 * half, 2))
    own[:half, 0] = own[half:, 1] = 1.0
    found = transfer_weights(mesh, faces, model, faces, own)
    np.testing.assert_allclose(found, own, atol=1e-12)


def test_a_part_that_no_skin_agrees_with_keeps_the_nearest():
    """Broken where a mesh without any vertex to start from ends without weights."""
    model, faces, half = legs(0.1)
    own = np.zeros((2 * half, 2))
    own[:half, 0] = own[half:, 1] = 1.0
    found = transfer_weights(model, faces[:, ::-1], model, faces, own)
    np.testing.assert_allclose(found, own, atol=1e-12)
