"""Skinning, weights around a body, and the exact signed distance."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body import JOINTS, Body, builtin_body, rest_body, signed_distance, skin, unskin, weights_at


@pytest.fixture(scope="module")
def body() -> Body:
    """Give a body whose arms hang, so that its pose differs from its rest pose."""
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


def test_distance_of_a_ball_is_exact() -> None:
    """Signs, scale and gradient against the closed form, from a mesh with a missing face."""
    import trimesh

    ball = trimesh.creation.icosphere(4, 0.5)
    base = builtin_body("builtin:female")
    solid = replace(base, vertices=np.array(ball.vertices), faces=np.array(ball.faces)[1:])
    points = np.random.default_rng(0).normal(0, 0.5, (400, 3))
    points = points[np.abs(np.linalg.norm(points, axis=1) - 0.5) > 0.02]
    distance, gradient = signed_distance(solid, points)
    radius = np.linalg.norm(points, axis=1)
    # The polyhedron lies up to 0.5 (1 - cos(edge / 2 radius)), about 0.7 mm, inside the sphere; a lost face adds depth.
    assert np.allclose(distance, radius - 0.5, atol=2e-3)
    assert (np.sign(distance) == np.sign(radius - 0.5)).all()
    outside = distance > 0.05
    assert np.einsum("ij,ij->i", gradient, points / radius[:, None])[outside].min() > 0.99


def test_gradient_is_the_derivative_of_the_distance(body: Body) -> None:
    """A gradient of the wrong sign inside pushes cloth deeper."""
    rng = np.random.default_rng(1)
    points = body.vertices[rng.choice(len(body.vertices), 200)] + rng.normal(0, 0.03, (200, 3))
    distance, gradient = signed_distance(body, points)
    ahead, _ = signed_distance(body, points + 1e-5 * gradient)
    assert np.median(np.abs((ahead - distance) / 1e-5 - 1)) < 1e-6
    assert (np.linalg.norm(gradient, axis=1) == pytest.approx(1.0)) and (distance < 0).any() and (distance > 0).any()


def test_gradient_on_the_surface_is_the_outward_normal(body: Body) -> None:
    """On the surface the direction to the closest point is lost; a zero or NaN there would stop a solver."""
    centres = body.vertices[body.faces].mean(axis=1)[::50]
    distance, gradient = signed_distance(body, centres)
    corners = body.vertices[body.faces[::50]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.abs(distance).max() < 1e-9
    assert np.einsum("ij,ij->i", gradient, normal / np.linalg.norm(normal, axis=1)[:, None]).min() > 0.9


def test_no_points_give_no_distances(body: Body) -> None:
    """An empty query must not reach the library, which reshapes it."""
    distance, gradient = signed_distance(body, np.zeros((0, 3)))
    assert distance.shape == (0,) and gradient.shape == (0, 3)


def test_the_type_loads_no_heavy_library() -> None:
    """An import of torch at package level costs the command line its quick answer."""
    code = (
        "import sys; from garmentq.core.body import Body; print({'torch', 'igl', 'numba', 'scipy'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
