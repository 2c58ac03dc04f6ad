"""The network: what torch trains and what numpy runs are one, and the trainer learns what is there to learn."""

import json
from dataclasses import replace
from hashlib import sha256
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from garmentq.core.people.features import FEATURE_NAMES
from garmentq.core.people.limbs import Limb
from garmentq.core.people.networks import LIMB_STATION_COUNT, LimbCells, NetworkEnsemble, load_ensemble
from garmentq.core.people.part import PARTS
from garmentq.training.describe import Described
from garmentq.training.judge import find_temperature, judge, judge_labels
from garmentq.training.kinds import harden, write_kinds
from garmentq.training.network import PersonNetwork, load_network, save_weights, to_torch
from garmentq.training.train import begin_network, cells_of, predict, soften, train_network


def draw_scan(seed, count=600):
    """Return a made-up described scan: sleeves end at a station that no sample's features but its own place tell."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(count, len(FEATURE_NAMES))).astype(np.float32)
    limb = rng.integers(0, len(Limb), count)
    station = rng.uniform(0.0, 0.7, count)
    end = rng.uniform(0.2, 0.5)
    values[:, 0] = np.where(station < end, 1.0, 0.0) + rng.normal(0, 0.7, count)
    label = np.where(station < end, 10, 0).astype(np.uint8)
    zero = np.zeros(count)
    rules = np.full((count, len(PARTS)), 1 / len(PARTS))
    place = np.zeros((count, 3))
    return Described(values, place, place, limb, station, rules, rules, label, zero, zero, zero, {})


def test_numpy_runs_what_torch_trained(tmp_path):
    """Broken where a layer of one is not that of the other: the shipped posterior would be of another network."""
    torch.manual_seed(1)
    scan = draw_scan(0)
    network = PersonNetwork(scan.inputs.mean(axis=0), scan.inputs.std(axis=0) + 1e-3).eval()
    for value in network.parameters():  # in half precision, as the file has them
        value.data = value.data.half().float()
    save_weights(network, 1.7, tmp_path / "weights.npz", {"seed": 1})
    loaded = load_network(tmp_path / "weights.npz")
    front, side = (scan.values[:, FEATURE_NAMES.index(name)] for name in ("around_front", "around_side"))
    hidden = loaded.embed(scan.inputs, LimbCells.of(scan.limb, scan.station, front, side))
    logits = hidden @ loaded.weights["part.weight"].T + loaded.weights["part.bias"]
    assert logits == pytest.approx(predict(network, scan), abs=2e-5)
    assert loaded.temperature == pytest.approx(1.7)
    kept = json.loads((tmp_path / "weights.json").read_text())
    assert kept["sha256"] == sha256((tmp_path / "weights.npz").read_bytes()).hexdigest()
    assert (tmp_path / "weights.npz").stat().st_size < 1e6


def test_numpy_runs_what_torch_trained_of_kinds(tmp_path):
    """Broken where what ships is not what was trained: a layer, what the rules say, the temperature, the layout."""
    torch.manual_seed(2)
    rules = np.random.default_rng(3).dirichlet(np.ones(len(PARTS)), 600)
    scan = replace(draw_scan(1), rules=rules)
    network = PersonNetwork(scan.kind_inputs.mean(axis=0), scan.kind_inputs.std(axis=0) + 1e-3, True).eval()
    for value in network.parameters():
        value.data = value.data.half().float()
    write_kinds(NetworkEnsemble((harden(network, 1.3),)), tmp_path / "kinds.npz", {})
    place = SimpleNamespace(limb=scan.limb, station=scan.station)
    features = SimpleNamespace(
        values=scan.values, place=place, column=lambda name: scan.values[:, FEATURE_NAMES.index(name)]
    )
    found = load_ensemble(tmp_path / "kinds.npz").predict_kinds(features, rules)
    assert found == pytest.approx(soften(predict(network, scan), 1.3), abs=1e-4)


def test_training_goes_on_from_what_was_trained():
    """Broken where weights, or the scaling of the inputs, are drawn anew: all that is known would be learnt again."""
    torch.manual_seed(4)
    first, other = draw_scan(2), replace(draw_scan(3), values=3.0 * draw_scan(3).values)
    network = PersonNetwork(first.kind_inputs.mean(axis=0), first.kind_inputs.std(axis=0) + 1e-3, True)
    kept = harden(network, 1.0)
    trained = {name: value for name, value in kept.weights.items() if not name.startswith("present")}
    again = begin_network([other.kind_inputs], True, replace(kept, weights=trained))
    assert predict(again.eval(), other) == pytest.approx(predict(network.eval(), other), abs=1e-2)


def test_weights_of_another_layout_are_refused(tmp_path):
    """Broken where features in another order are read by weights that were trained on the old one."""
    network = PersonNetwork(np.zeros(len(FEATURE_NAMES)), np.ones(len(FEATURE_NAMES)))
    save_weights(network, 1.0, tmp_path / "weights.npz", {})
    with np.load(tmp_path / "weights.npz") as kept:
        arrays = dict(kept)
    np.savez(tmp_path / "old.npz", **arrays | {"version": -1})
    assert load_network(tmp_path / "old.npz") is None
    assert load_network(tmp_path / "none.npz") is None


def test_cells_follow_the_limb():
    """Broken where samples of two limbs, of two stations or of front and back share a cell."""
    limb = np.array([0, 1, 2, 2, 2, 2])
    station = np.array([0.1, 0.1, 0.1, 0.13, 0.1, -5.0])
    front = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0])
    cells = LimbCells.of(limb, station, front, np.zeros(6))
    assert len(set(cells.index.tolist())) == 6
    assert cells.index[5] == 2 * 4 * LIMB_STATION_COUNT
    assert ((cells.low == cells.index) | (cells.high == cells.index)).all()
    assert (cells.share >= 0).all() and (cells.share <= 1).all()
    assert to_torch(cells)[0].dtype == torch.int64


@pytest.mark.nightly
def test_the_trainer_learns_from_neighbours():
    """Broken where pooling along limbs tells nothing: one sample's own features are right 4 times in 5."""
    network = train_network([draw_scan(seed) for seed in range(24)], epochs=40)
    scan = draw_scan(99)
    posterior = soften(predict(network, scan), 1.0)
    assert judge([posterior], [scan.label]).accuracy > 0.9
    assert len(cells_of(scan)) == 4


def test_figures_of_known_posteriors():
    """Broken where intersection over union, calibration or the share of sure samples is counted wrongly."""
    labels = np.array([0, 0, 10, 10])
    posterior = np.full((4, len(PARTS)), 0.0)
    skin, upper = PARTS.index(0), PARTS.index(10)
    posterior[[0, 1, 2], skin] = [0.95, 0.95, 0.6]
    posterior[2, upper], posterior[3, upper] = 0.4, 1.0
    figures = judge([posterior], [labels])
    assert figures.accuracy == pytest.approx(0.75)
    assert figures.mean_iou == pytest.approx((2 / 3 + 1 / 2) / 2)
    assert figures.cloth_iou == pytest.approx(0.5)
    assert figures.sure == pytest.approx(0.75)
    assert figures.sure_right == pytest.approx(1.0)


@pytest.mark.parametrize(("confidence", "right", "error"), [(0.8, 8, 0.0), (1.0, 5, 0.5)])
def test_confidence_of_labels_is_judged(confidence, right, error):
    """Broken where the posterior's largest is taken for the confidence that was stated."""
    found, true = np.zeros(10, int), np.array([0] * right + [10] * (10 - right))
    assert judge_labels([found], [np.full(10, confidence)], [true]).ece == pytest.approx(error, abs=1e-12)


def test_the_temperature_is_found():
    """Broken where logits that are twice too sure are not halved."""
    rng = np.random.default_rng(0)
    logits = rng.normal(size=(20000, 3))
    chance = np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True)
    labels = (rng.random((20000, 1)) > chance.cumsum(axis=1)).sum(axis=1)
    assert find_temperature(2 * logits, labels) == pytest.approx(2.0, rel=0.05)
