"""Registration of meshes that are only meshes."""

import igl
import numpy as np
import pytest
import trimesh
from everyday_body import everyday_body
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.competing_starts import SearchSettings
from garmentq.core.body.fit import FitStage, FitState, Fitter, OrientedPoints
from garmentq.core.body.registration import NotHuman, RegistrationSettings, register_body
from garmentq.core.body.skinning import rest_body, skin
from garmentq.core.body.template import load_template, rotations_of
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.run.errors import Cancelled
from garmentq.core.run.hooks import Hooks

TEMPLATE = load_template()


@pytest.fixture(scope="module")
def registered() -> tuple[Body, np.ndarray, np.ndarray, np.ndarray, float]:
    """Register one everyday body for all tests that only look at the outcome."""
    vertices, faces, joints, heading = everyday_body(TEMPLATE, 3)
    return register_body(vertices, faces, name="someone"), vertices, faces, joints, heading


def check_joints(body: Body, joints: np.ndarray) -> None:
    """Describe a registered body's joints against the true ones: 15 mm on average, none swapped."""
    error = np.linalg.norm(body.joints - joints, axis=1)
    assert error.mean() < 0.015
    for left, right in (("left_hip", "right_hip"), ("left_foot", "right_foot"), ("left_wrist", "right_wrist")):
        i, j = JOINTS.index(left), JOINTS.index(right)
        assert error[i] < np.linalg.norm(body.joints[i] - joints[j])


@pytest.mark.slow
def test_everyday_body_gets_its_joints(registered: tuple) -> None:
    """A start in the wrong heading that wins swaps left and right; weak pairs leave limbs centimetres off."""
    body, vertices, faces, joints, heading = registered
    check_joints(body, joints)
    assert body.fit_rms < 0.004 and body.source == "mesh:someone"
    assert np.array_equal(body.vertices, vertices) and np.array_equal(body.faces, faces)
    front = body.heading @ [np.sin(heading), 0, np.cos(heading)]
    assert front[2] > np.cos(np.radians(10)) and np.allclose(body.heading @ [0, 1, 0], [0, 1, 0])


@pytest.mark.slow
def test_registered_body_is_consistent(registered: tuple) -> None:
    """Weights, transforms and rest pose must belong together, or a garment carried into the pose misses the body."""
    body, vertices, *_ = registered
    assert np.allclose(body.weights.sum(axis=1), 1) and body.weights.min() >= 0
    posed_joints = np.einsum("jab,jb->ja", body.transforms, np.c_[body.rest_joints, np.ones(24)])[:, :3]
    assert np.allclose(posed_joints, body.joints)
    model = skin(body.rest_vertices, body.rest_weights, body.transforms)
    distance = np.sqrt(igl.point_mesh_squared_distance(vertices, model, body.rest_faces)[0])
    assert np.sqrt((distance**2).mean()) < 0.006
    still = rest_body(body)
    assert still.vertices[:, 1].min() == pytest.approx(0, abs=1e-9)
    assert still.joint("left_wrist")[0] > 0.5 and still.joint("left_foot")[2] > still.joint("left_ankle")[2]


@pytest.mark.slow
def test_a_moved_mesh_gives_the_same_joints_moved(registered: tuple) -> None:
    """A heading or place that the starts favour would show as other joints on the same body."""
    body, vertices, faces, joints, _ = registered
    turn, shift = rotations_of(np.array([0.0, 2.0, 0.0])), np.array([3.0, -0.7, 1.5])
    moved = register_body(vertices @ turn.T + shift, faces[:, ::-1])
    check_joints(moved, joints @ turn.T + shift)
    assert np.linalg.norm(moved.joints - (body.joints @ turn.T + shift), axis=1).mean() < 0.005
    assert np.array_equal(moved.faces, faces)


def test_derivatives_by_pose_and_shape_agree_with_differences() -> None:
    """A wrong column in the Jacobian sends a limb or the shape astray in every fit."""
    rng = np.random.default_rng(0)
    subset = np.arange(0, len(TEMPLATE.vertices), 250)
    fitter = Fitter(TEMPLATE, subset, OrientedPoints(np.zeros((1, 3)), np.array([[0.0, 1.0, 0.0]])))
    state = FitState(rng.normal(0, 1, 6), rotations_of(rng.normal(0, 0.4, (24, 3))), rng.normal(0, 1, 3))
    placed = fitter._place(state)
    turn, shape = fitter._turn_slopes(placed), fitter._shape_slopes(6, placed)
    h = 1e-6
    for column in (1, 5, 17, 40, 71):
        step = np.zeros(72)
        step[column] = h
        ends = [FitState(state.shape, rotations_of(s * step.reshape(24, 3)) @ state.rotations, state.translation)
                for s in (1, -1)]  # fmt: skip
        slope = (fitter._place(ends[0]).points - fitter._place(ends[1]).points) / (2 * h)
        assert np.allclose(slope, turn[:, column].T, atol=1e-7)
    for k in range(6):
        step = np.eye(6)[k] * h
        ends = [FitState(state.shape + s * step, state.rotations, state.translation) for s in (1, -1)]
        slope = (fitter._place(ends[0]).points - fitter._place(ends[1]).points) / (2 * h)
        assert np.allclose(slope, shape[:, k].T, atol=1e-7)


def test_a_fit_from_the_true_state_stays_there() -> None:
    """Pairs or priors with a bias would walk away from a surface that the model matches."""
    body = builtin_body("builtin:female")
    subset = np.arange(0, len(TEMPLATE.vertices), 10)
    state = FitState(body.parameters["shape"], np.tile(np.eye(3), (24, 1, 1)), np.zeros(3))
    rest, _ = TEMPLATE.shaped(state.shape)
    normals = vertex_normals(rest, TEMPLATE.faces)
    fitter = Fitter(TEMPLATE, subset, OrientedPoints(rest, normals))
    after = fitter.fit(state, FitStage(3, 0.01, 0.03, True, 60))
    rest_after, _ = TEMPLATE.shaped(after.shape)
    assert np.abs(rest_after - rest).max() < 0.003
    assert np.abs(after.translation).max() < 0.001
    assert fitter.residual(after, 0.05, 0.05) < 1.02 * fitter.residual(state, 0.05, 0.05)


def test_a_cube_is_no_person() -> None:
    """A wrong mesh must be refused with a stable code, not given bones."""
    cube = trimesh.creation.box((1.0, 1.0, 1.0)).subdivide().subdivide()
    search = SearchSettings(coarse_count=60, fine_count=300, kept=(2, 1, 1))
    quick = RegistrationSettings(search, surface_count=600)
    with pytest.raises(NotHuman, match="metres") as caught:
        register_body(cube.vertices, cube.faces, settings=quick)
    assert caught.value.code == "body.not_human"


def test_millimetres_are_no_person() -> None:
    """A body in millimetres would search for ever in the wrong scale; the height says it at once."""
    body = builtin_body("builtin:male")
    with pytest.raises(NotHuman, match="high"):
        register_body(1000 * body.vertices, body.faces)


def test_an_empty_mesh_and_nan_are_no_person() -> None:
    """A mesh with nothing to sample must end in the same clear refusal, not in a traceback."""
    body = builtin_body("builtin:male")
    with pytest.raises(NotHuman):
        register_body(body.vertices, np.zeros((0, 3), int))
    with pytest.raises(NotHuman):
        register_body(np.where(body.vertices > 1.7, np.nan, body.vertices), body.faces)


def test_cancelling_stops_the_search() -> None:
    """A cancelled job must not fit on for seconds."""
    body = builtin_body("builtin:male")
    with pytest.raises(Cancelled):
        register_body(body.vertices, body.faces, hooks=Hooks(is_cancelled=lambda: True))
