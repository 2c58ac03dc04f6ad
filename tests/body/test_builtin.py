"""The built-in body: its description, shape, pose and derivatives."""

from pathlib import Path

import numpy as np
import pytest
import torch
import trimesh
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import BODY_DENSITY, BodyMissing, BodySpecBad, builtin_body
from garmentq.core.body.skinning import rest_body
from garmentq.core.body.spec import BuiltinWearer, read_wearer
from garmentq.core.body.template import load_template, rotations_of
from garmentq.training.body_model import BodyModel

TEMPLATE = load_template()


@pytest.mark.parametrize("gender", ["female", "male"])
@pytest.mark.parametrize("height", [1.50, 1.70, 1.95])
def test_stature_is_the_one_asked_for(gender: str, height: float) -> None:
    """A wrong constraint in the shape solve gives a body of another height."""
    body = builtin_body(f"builtin:{gender},height={height}")
    assert np.ptp(body.vertices[:, 1]) == pytest.approx(height, abs=0.002)
    assert body.vertices[:, 1].min() == pytest.approx(0, abs=1e-9)


def test_weight_is_the_one_asked_for() -> None:
    """A wrong volume derivative leaves the weight off, and would change the height with it."""
    body = builtin_body("builtin:male,height=1.80,weight=95")
    mesh = trimesh.Trimesh(body.vertices, body.faces, process=False)
    assert mesh.volume * BODY_DENSITY == pytest.approx(95, abs=0.1)
    assert np.ptp(body.vertices[:, 1]) == pytest.approx(1.80, abs=0.002)


def test_surface_is_one_closed_piece_that_faces_outward() -> None:
    """A hole at the mouth, a loose eye or flipped faces in the asset would break the signed distance."""
    body = builtin_body("builtin:female")
    mesh = trimesh.Trimesh(body.vertices, body.faces, process=False)
    assert mesh.is_watertight and mesh.body_count == 1 and mesh.euler_number == 2
    assert mesh.volume > 0.04


def test_sides_and_front_are_right() -> None:
    """A mirrored asset or a swapped joint table puts the left hand at -x or the toes behind the heel."""
    body = builtin_body("builtin:female")
    for name in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist"):
        assert body.joint(f"left_{name}")[0] > 0 > body.joint(f"right_{name}")[0]
    for side in ("left", "right"):
        assert body.joint(f"{side}_foot")[2] > body.joint(f"{side}_ankle")[2] + 0.05
    spine = [body.joint(name)[1] for name in ("pelvis", "spine1", "spine2", "spine3", "neck", "head")]
    assert spine == sorted(spine)
    nose = body.vertices[body.vertices[:, 1] > body.joint("head")[1]]
    assert nose[:, 2].max() - body.joint("head")[2] > body.joint("head")[2] - nose[:, 2].min()


@pytest.mark.parametrize(("pose", "lower"), [("A", 0.25), ("arms-down", 0.4)])
def test_arms_drop_and_legs_stay(pose: str, lower: float) -> None:
    """A wrong sign lifts an arm; a pose that leaks into the legs moves the feet."""
    stand, dropped = builtin_body("builtin:female"), builtin_body(f"builtin:female,pose={pose}")
    for side in ("left", "right"):
        assert stand.joint(f"{side}_wrist")[1] - dropped.joint(f"{side}_wrist")[1] > lower
        assert np.allclose(stand.joint(f"{side}_ankle"), dropped.joint(f"{side}_ankle"))
    assert np.allclose(rest_body(dropped).vertices, stand.vertices)


@pytest.mark.parametrize(
    "spec",
    ["builtin", "builtin:", "builtin:alien", "female", "builtin:female,size=3", "builtin:female,height=tall",
     "builtin:female,height=nan", "builtin:female,height=170", "builtin:female,pose=sitting", "builtin:male,weight=400",
     "builtin:female,height=1.6,height=1.7"],
)  # fmt: skip
def test_bad_descriptions_are_refused(spec: str) -> None:
    """A description that slips through would dress another body than the one meant."""
    with pytest.raises(BodySpecBad) as caught:
        builtin_body(spec)
    assert caught.value.code == "body.spec_bad"


def test_unknown_key_names_the_allowed_ones() -> None:
    """Without the allowed keys the message gives no next step."""
    with pytest.raises(BodySpecBad, match=r"height.*weight.*pose"):
        builtin_body("builtin:female,size=3")


def test_no_body_names_the_next_step() -> None:
    """An empty description must end in the advice to give a mesh or the built-in body."""
    with pytest.raises(BodyMissing, match=r"builtin:female,height=1\.70") as caught:
        builtin_body("")
    assert caught.value.code == "body.missing"


def test_torch_model_agrees_with_the_numpy_one() -> None:
    """Two articulations that disagree would make a fit's body differ from the one it is used with."""
    body = builtin_body("builtin:female,height=1.7,pose=A")
    shape, pose = torch.from_numpy(body.parameters["shape"]), torch.from_numpy(body.parameters["pose"])
    posed = BodyModel().pose(shape, pose)
    lift = body.vertices[0] - posed.vertices[0].numpy()
    assert np.allclose(posed.vertices.numpy() + lift, body.vertices, atol=1e-12)
    assert np.allclose(posed.joints.numpy() + lift, body.joints, atol=1e-12)
    assert np.allclose(posed.transforms[:, :3, :3].numpy(), body.transforms[:, :3, :3], atol=1e-12)


def test_zero_pose_is_the_rest_pose() -> None:
    """Linear blend skinning with identity rotations must move nothing."""
    model = BodyModel(TEMPLATE)
    shape = torch.from_numpy(TEMPLATE.means["male"])
    posed = model.pose(shape, torch.zeros(24, 3, dtype=torch.float64))
    rest, joints = model.rest(shape)
    assert torch.allclose(posed.vertices, rest, atol=1e-14) and torch.allclose(posed.joints, joints, atol=1e-14)
    assert torch.allclose(posed.transforms, torch.eye(4, dtype=torch.float64).expand(24, 4, 4), atol=1e-14)


@pytest.mark.parametrize("at_zero", [False, True])
def test_derivatives_agree_with_finite_differences(at_zero: bool) -> None:
    """A detached tensor, or the missing derivative of Rodrigues' formula at zero, shows here."""
    rng = np.random.default_rng(0)
    model = BodyModel(TEMPLATE)
    point = [np.zeros(60), np.zeros((24, 3)), np.zeros(3)]
    if not at_zero:
        point = [rng.normal(0, s, p.shape) for s, p in zip((1, 0.4, 1), point, strict=True)]
    probe = torch.from_numpy(rng.normal(0, 1, TEMPLATE.vertices.shape))

    def value(values: list[np.ndarray]) -> torch.Tensor:
        tensors = [torch.from_numpy(v).requires_grad_(True) for v in values]
        posed = model.pose(*tensors)
        total = (posed.vertices * probe).sum() + (posed.joints**2).sum()
        total.backward()
        slopes.append([t.grad.numpy() for t in tensors])
        return total.detach()

    slopes: list[list[np.ndarray]] = []
    value(point)
    step = [rng.normal(0, 1, p.shape) for p in point]
    h = 1e-6
    ahead = value([p + h * s for p, s in zip(point, step, strict=True)])
    behind = value([p - h * s for p, s in zip(point, step, strict=True)])
    expected = sum(float((g * s).sum()) for g, s in zip(slopes[0], step, strict=True))
    assert float(ahead - behind) / (2 * h) == pytest.approx(expected, rel=1e-6)


def test_rotations_match_scipy() -> None:
    """A sign slip in Rodrigues' formula turns every joint the wrong way."""
    from scipy.spatial.transform import Rotation

    vectors = np.vstack([np.zeros(3), np.random.default_rng(0).normal(0, 1.5, (20, 3))])
    assert np.allclose(rotations_of(vectors), Rotation.from_rotvec(vectors).as_matrix())


def test_joint_names_are_smpls() -> None:
    """The order is a contract with every other room."""
    assert len(JOINTS) == 24 == len(TEMPLATE.joints)


def test_a_wearer_is_a_description_or_a_file():
    """Broken where a file named like a description is read as one, or a path becomes a description."""
    assert read_wearer(None) is None
    assert read_wearer("builtin:male,height=1.8") == BuiltinWearer("builtin:male,height=1.8")
    assert read_wearer("my builtin:male.ply") == Path("my builtin:male.ply")
    with pytest.raises(ValueError, match=r"body\.ply"):
        BuiltinWearer("body.ply")
