"""Simulated persons: wearers that could stand so, dressed, and the same for the same seed."""

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.template import load_template
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.people.part import GARMENTS, Part
from garmentq.training.accessories import hair_shell, load_accessories, shoe_shell, worn_asset
from garmentq.training.cloth import border_vertices
from garmentq.training.persons import simulate
from garmentq.training.shells import draw_leggings, draw_tight_suit, draw_tight_top, draw_underwear, wear_shell
from garmentq.training.wearer import (
    CHILD_SIZE,
    POSES,
    at_rest,
    draw_motion_pose,
    mirror_pose,
    pose_angles,
    runs_into_itself,
    shrink,
    stand,
)


@pytest.fixture(scope="module")
def template():
    """Return the built-in body."""
    return load_template()


@pytest.mark.parametrize("name", [name for name, _ in POSES])
def test_named_poses_are_clear_of_the_body(template, name):
    """Broken where a start pose puts a limb into another part of the body, or the person floats."""
    body = stand(template, template.means["female"], pose_angles(name))
    assert not runs_into_itself(body)
    assert body.vertices[:, 1].min() == pytest.approx(0.0, abs=1e-9)


def test_raised_arms_are_up_and_hands_on_hips_low(template):
    """Broken where a turn goes the wrong way about its axis."""
    shape = template.means["male"]
    hand = JOINTS.index("left_hand")
    heights = {name: stand(template, shape, pose_angles(name)).joints[hand] for name, _ in POSES}
    head = stand(template, shape, pose_angles("up")).joint("head")
    assert heights["up"][1] > head[1]
    assert heights["goalpost"][1] > head[1] - 0.05
    assert heights["hips"][1] < head[1] - 0.4
    assert abs(heights["hips"][0]) < 0.3
    assert heights["forward"][2] > 0.3


def test_arms_in_the_trunk_are_noticed(template):
    """Broken where a person whose arms are inside the trunk would be dressed and scanned."""
    angles = pose_angles("A")
    for side, sign in (("left", -1.0), ("right", 1.0)):
        angles[JOINTS.index(f"{side}_shoulder"), 2] = sign * 1.75
    assert runs_into_itself(stand(template, template.means["female"], angles))


def test_accessories_are_where_they_are_worn(template):
    """Broken where hair is not about the head or shoes not about the feet of whoever wears them."""
    body = stand(template, 0.8 * template.means["male"], pose_angles("T"))
    head, ankle = body.joint("head"), body.joint("left_ankle")
    for name, asset in load_accessories().items():
        vertices, _ = worn_asset(template, body, asset, 1.0)
        if name.startswith("shoes"):
            assert vertices[:, 1].max() < ankle[1] + 0.2
            assert vertices[:, 1].min() < 0.02
        else:
            assert vertices[:, 1].max() > head[1] + 0.1
            assert np.abs(vertices[:, 0]).max() < 0.3
    rng = np.random.default_rng(1)
    assert hair_shell(body, rng)[0][:, 1].min() > head[1] - 0.1
    assert shoe_shell(body, rng)[0][:, 1].max() < 0.5


@pytest.mark.nightly
def test_a_person_is_dressed_and_the_same_again():
    """Broken where a seed gives another person the next time, or somebody without clothes, or cloth inside the body."""
    first, second = (next(iter(simulate(11, 1))) for _ in range(2))
    assert (first.points == second.points).all()
    assert (first.label == second.label).all()
    parts = {Part(number) for number in np.unique(first.label)}
    assert Part.SKIN in parts
    garment = np.isin(first.label, [int(part) for part in GARMENTS])
    assert first.tightness[garment].mean() > first.tightness[first.label == 0].mean()


def test_poses_out_of_motions_stand_on_the_floor_and_mirror(template):
    """Broken where a mirrored pose is another one, or motions leave people in the air."""
    _, angles = draw_motion_pose(np.random.default_rng(3))
    body, twin = (stand(template, template.means["male"], one) for one in (angles, mirror_pose(angles)))
    assert body.vertices[:, 1].min() == pytest.approx(0.0, abs=1e-9)
    assert mirror_pose(mirror_pose(angles)) == pytest.approx(angles)
    assert twin.joint("left_hand") == pytest.approx(body.joint("right_hand") * [-1.0, 1.0, 1.0], abs=0.03)


@pytest.mark.parametrize("size", CHILD_SIZE)
def test_a_child_is_smaller_and_its_head_less_so(template, size):
    """Broken where a child's skeleton leaves its skin, or its head shrinks as its legs do."""
    child = shrink(template, size)
    shape = template.means["female"]
    small, tall = (stand(one, shape, pose_angles("A")) for one in (child, template))
    assert np.ptp(small.joints[:, 1]) == pytest.approx(size * np.ptp(tall.joints[:, 1]), rel=1e-6)
    head = template.weights[:, JOINTS.index("head")] > 0.95
    assert np.ptp(small.vertices[head, 1]) == pytest.approx(size**0.5 * np.ptp(tall.vertices[head, 1]), rel=0.01)
    assert not runs_into_itself(small)


@pytest.mark.parametrize("draw", [draw_leggings, draw_tight_top, draw_tight_suit])
def test_what_follows_the_body_lies_on_it_and_ends(template, draw):
    """Broken where tight cloth is inside the skin, has no end, or covers head or hands."""
    rest = at_rest(stand(template, template.means["female"], np.zeros((24, 3))))
    rng = np.random.default_rng(5)
    for _ in range(4):
        shell = draw(rest, rng)
        vertices, faces = wear_shell(shell, rest, rng).mesh
        height = TriangleSurface(rest.vertices, rest.faces).heights(vertices)
        assert np.median(height) == pytest.approx(shell.thickness, rel=0.6)
        assert len(border_vertices((vertices, faces))) > 20
        assert 0.05 < (shell.keep > 0).mean() < 0.85
        assert (shell.keep[rest.vertices[:, 1] > rest.joint("head")[1] + 0.05] <= 0).all()


def test_underwear_counts_as_skin_and_little_is_covered(template):
    """Broken where underwear is a garment, or a swimsuit has legs."""
    rest = at_rest(stand(template, template.means["female"], np.zeros((24, 3))))
    knee = rest.joint("left_knee")[1]
    for seed in range(20):
        for shell in draw_underwear(rest, "female", np.random.default_rng(seed)):
            assert shell.part is Part.SKIN
            worn = rest.vertices[shell.keep > 0]
            assert len(worn) and worn[:, 1].min() > knee and np.abs(worn[:, 0]).max() < 0.3


@pytest.mark.nightly
def test_all_of_it_runs_on_a_tiny_set(tmp_path):
    """Broken where a fresh clone cannot repeat the training: persons, their fits and features, weights that load."""
    from garmentq.training.describe import describe_folder
    from garmentq.training.network import load_network, save_weights
    from garmentq.training.persons import write_persons
    from garmentq.training.train import load_set, train_network

    assert write_persons(tmp_path / "scans", range(1, 3), 1, simulate) == 2
    assert write_persons(tmp_path / "scans", range(1, 3), 1, simulate) == 0
    assert describe_folder(tmp_path / "scans", tmp_path / "samples") >= 1
    scans = load_set(tmp_path / "samples")
    network = train_network(scans, 1)
    save_weights(network, 1.0, tmp_path / "weights.npz", {"persons": 2})
    assert load_network(tmp_path / "weights.npz") is not None
    assert (tmp_path / "weights.npz").stat().st_size < 1e6
