"""Skinning, weights around a body, and the exact signed distance."""

import subprocess
import sys

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.skinning import rest_body, skin, unskin, weights_at


@pytest.fixture(scope="module")
def body() -> Body:
    """Return a body whose arms hang, so that its pose differs from its rest pose."""
    return builtin_body("builtin:female,pose=A")


def test_skinning_the_rest_vertices_gives_the_pose(body: Body) -> None:
    """Transforms that are not from rest space to the pose put the skin elsewhere than the vertices."""
    assert np.allclose(skin(body.rest_vertices, body.rest_weights, body.transforms), body.vertices, atol=1e-12)


def test_unskin_undoes_skin(body: Body) -> None:
    """A garment carried into the pose and back must be where it was."""
    points = np.random.default_rng(0).uniform([-0.8, 0, -0.3], [0.8, 1.7, 0.3], (300, 3))
    weights = weights_at(body, points, rest=True)
    assert np.allclose(unskin(skin(points, weights, body.transforms), weights, body.transforms), points, atol=1e-9)


def test_identity_transforms_move_nothing(body: Body) -> None:
    """Weights that do not sum to one would shrink a garment towards the origin."""
    still = rest_body(body)
    points = body.rest_vertices + 0.02
    assert np.allclose(skin(points, weights_at(still, points, rest=False), still.transforms), points, atol=1e-12)


def test_weights_are_smooth_and_follow_the_near_limb(body: Body) -> None:
    """A jump from one bone to another tears the cloth; the wrong pose's surface gives the wrong limb."""
    wrist, elbow = body.joint("left_wrist"), body.joint("left_elbow")
    line = np.linspace(elbow, wrist, 400) + [0, 0, 0.06]
    weights = weights_at(body, line, rest=False)
    assert np.allclose(weights.sum(axis=1), 1)
    assert weights.min() >= 0
    assert weights[200].argmax() == JOINTS.index("left_elbow")
    assert np.abs(np.diff(weights, axis=0)).max() < 0.05
    hanging = builtin_body("builtin:female,pose=arms-down")
    place = hanging.joint("left_wrist")[None] - [0.05, 0, 0]
    assert weights_at(hanging, place, rest=False).argmax() >= JOINTS.index("left_elbow")
    # In rest space the arm is stretched out far from there, and the hip is nearest.
    assert weights_at(hanging, place, rest=True).argmax() in (JOINTS.index("left_hip"), JOINTS.index("pelvis"))


def test_the_type_loads_no_heavy_library() -> None:
    """An import of torch at package level costs the command line its quick answer."""
    code = (
        "import sys; from garmentq.core.body.body import Body; "
        "print({'torch', 'igl', 'numba', 'scipy'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
