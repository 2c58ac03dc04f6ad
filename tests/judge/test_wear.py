"""What is no garment fails a gate: nothing bears it, it lies in layers, or it hangs upside down."""

from dataclasses import dataclass

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.skinning import skin, weights_at
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.judge.gates import evaluate_gates
from garmentq.core.judge.wear import measure_sides, measure_upright, measure_wear
from garmentq.core.scan.contours.target import Contour, Target

AROUND, ROWS = 60, 30


@dataclass(frozen=True)
class Torso:
    """Stand for a body: a post 30 cm thick."""

    vertices: np.ndarray
    faces: np.ndarray


def make_tube(low, high, bottom=0.6, top=1.0):
    """Return a tube around the y axis with radii [m] below and above."""
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    share = np.linspace(0.0, 1.0, ROWS)[:, None]
    radius = low + (high - low) * share
    y = np.broadcast_to(bottom + (top - bottom) * share, (ROWS, AROUND))
    points = np.stack([radius * np.sin(angle), y, radius * np.cos(angle)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(ROWS - 1), np.arange(AROUND), indexing="ij")
    a, b = i * AROUND + j, i * AROUND + (j + 1) % AROUND
    return points, np.stack([a, b, b + AROUND, a, b + AROUND, a + AROUND], axis=-1).reshape(-1, 3)


def target_of(vertices, faces, waist=1.0, hem=1.5, hidden=False):
    """Return a skirt's target with contours of given lengths [m], its waist seen or not."""
    contours = (Contour("hem", np.arange(3), hem), Contour("waist", np.arange(3), waist, hidden=hidden))
    return Target(vertices, faces, vertex_normals(vertices, faces), contours, (), "skirt")


def verdicts(target, nodes, faces):
    """Return the verdict of each gate that judges how the scan is worn."""
    metrics = measure_wear(target, Torso(*make_tube(0.15, 0.15, 0.0, 1.5)), nodes, faces, seed=0)
    metrics |= measure_upright(target)
    return {gate.name: gate.verdict for gate in evaluate_gates(metrics)}


@pytest.fixture(scope="module")
def skirt():
    """Return a flared skirt that lies on the post above."""
    return make_tube(0.35, 0.155)


def test_a_skirt_passes(skirt):
    """Broken where flare, or cloth far from the body below, is held against a garment."""
    assert verdicts(target_of(*skirt), *skirt) == {"rest": "pass", "layers": "pass", "upright": "pass"}


def test_a_noisy_skirt_has_one_layer(skirt):
    """Broken where the area that noise adds to a dense scan is taken for layers of cloth."""
    vertices, faces = skirt
    rng = np.random.default_rng(0)
    for _ in range(2):
        middle = vertices[faces].mean(axis=1)
        centre = len(vertices) + np.arange(len(faces))
        faces = np.concatenate([np.column_stack([faces[:, k], faces[:, (k + 1) % 3], centre]) for k in range(3)])
        vertices = np.concatenate([vertices, middle])
    noisy = vertices + 0.002 * rng.standard_normal(vertices.shape)
    assert verdicts(target_of(noisy, faces), *skirt)["layers"] == "pass"


def test_a_curtain_fails(skirt):
    """Broken where a tube that touches the body nowhere passes for a skirt."""
    curtain = make_tube(0.4, 0.4)
    assert verdicts(target_of(*curtain), *curtain)["rest"] == "fail"


def test_four_copies_fail(skirt):
    """Broken where sheets 2 mm apart pass: distances to the scan do not show them."""
    vertices, faces = skirt
    normals = vertex_normals(vertices, faces)
    copies = np.concatenate([vertices + 0.002 * k * normals for k in range(4)])
    four = copies, np.concatenate([faces + k * len(vertices) for k in range(4)])
    assert verdicts(target_of(*four), *skirt)["layers"] == "fail"


def test_upside_down_fails(skirt):
    """Broken where a skirt may be far wider at its waist than at its hem."""
    assert verdicts(target_of(*skirt, waist=1.37, hem=0.96), *skirt)["upright"] == "fail"
    assert verdicts(target_of(*skirt, waist=0.7, hem=0.85), *skirt)["upright"] == "pass"


def test_the_hem_of_a_top_is_no_waist(skirt):
    """Broken where a skirt whose waist is hidden is judged by the border at which it vanishes, over the hips."""
    assert "upright" not in verdicts(target_of(*skirt, waist=1.37, hem=0.96, hidden=True), *skirt)


@pytest.mark.parametrize("pose", ["T", "stride"])
def test_a_leg_that_is_cut_short_is_found(pose):
    """Broken where legs of unlike length pass, or a stride makes legs of one length unlike."""
    body = builtin_body(f"builtin:female,height=1.70,pose={pose}")
    angle = 2.0 * np.pi * np.arange(40) / 40
    circle = 0.09 * np.stack([np.cos(angle), np.zeros(40), np.sin(angle)], axis=1)
    ankle = {side: body.rest_joints[JOINTS.index(f"{side}_ankle")] for side in ("left", "right")}

    def measure(short: float) -> float:
        rest = np.concatenate(
            [circle + ankle["left"] + [0.0, 0.05, 0.0], circle + ankle["right"] + [0.0, 0.05 + short, 0.0]]
        )
        worn = skin(rest, weights_at(body, rest, rest=True), body.transforms)
        ends = tuple(
            Contour(f"leg.{side}", rows, 0.56) for side, rows in zip(ankle, np.arange(80).reshape(2, 40), strict=True)
        )
        return measure_sides(worn, ends, body)["wear.sides_mm"]

    assert measure(0.0) < 8.0
    assert measure(0.08) == pytest.approx(80.0, abs=8.0)
    assert measure_sides(circle, (Contour("hem", np.arange(40), 0.56),), body) == {"wear.sides_mm": None}
