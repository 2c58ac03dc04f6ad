"""Simulated persons: wearers that could stand so, dressed, and the same for the same seed."""

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.template import load_template
from garmentq.core.people.part import GARMENTS, Part
from garmentq.training.accessories import hair_shell, load_accessories, shoe_shell, worn_asset
from garmentq.training.persons import simulate
from garmentq.training.wearer import POSES, pose_angles, runs_into_itself, stand


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
    assert parts & set(GARMENTS)
    garment = np.isin(first.label, [int(part) for part in GARMENTS])
    assert first.tightness[garment].mean() > first.tightness[first.label == 0].mean()


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
