"""Train the network and the boosted baseline: `python -m garmentq.training.train --samples DIR --out DIR`.

The samples are described scans. One person in eight is kept for validation: the temperature is found on these. Designs
that are kept for measuring are given as `--held-out DIR ...`.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch.nn import functional

from ..core.people import networks as learnt
from ..core.people.features import FEATURE_LAYOUT_VERSION, FEATURE_LENGTH_SCALE, FEATURE_NAMES
from ..core.people.limbs import Limb
from ..core.people.networks import KIND_OF_COLUMN, KINDS, LimbCells, kinds_to_parts, parts_to_kinds
from ..core.people.part import GARMENTS, PARTS
from .boosted import predict_boosted, save_boosted, train_boosted
from .describe import Described, load_described
from .judge import NUMBERS, Judged, find_temperature, judge
from .network import PersonNetwork, load_network, save_weights, to_torch
from .persons import REVISION

SAMPLES = 8000
"""Samples of a scan in one step, drawn anew each time: a third of them, which varies the density as scanners do."""
TOGETHER = 2
"""Scans whose gradients are summed up in a step."""
RATE = 3.0e-3
"""Highest learning rate (AdamW)."""
RATE_AGAIN = 1.0e-3
"""Highest learning rate where weights are trained on: a third, so that what they know is kept."""
LEAST_TIGHTNESS = 1.0e-3
"""Added to tightness before its logarithm is taken [m]: the fit's own noise."""
BORDER = 0.03
"""Distances to a border are clipped to this [m]."""
THICKER = 2.0e-3
"""Standard deviation by which the fitted body is made thicker or thinner in each step [m]: fits differ by as much."""
GRAIN = 0.03
"""Standard deviation of the noise that is added to the features, in their own units, which are about 1."""
FORGOTTEN = 0.08
"""Share of the features that are left out in each step, so that none is relied on alone."""
VALIDATED = 8
"""One person in so many is kept for validation."""

RAISED = ("offset", "distance", "slice_20", "slice_50", "slice_80", "slice_both")
_GROWS = [name in RAISED or name.startswith(("offset_mean", "typical_")) for name in FEATURE_NAMES]
OFFSETS = np.array(_GROWS + [False] * len(PARTS), np.float32)
"""1 for the inputs that grow with every offset from the body."""

COLUMN = np.zeros(256, np.int64)
COLUMN[NUMBERS] = np.arange(len(NUMBERS))


def _named(*starts: str) -> np.ndarray:
    """Return which inputs of a network of kinds have names that start so; the rules' come last."""
    return np.array([name.startswith(starts) for name in FEATURE_NAMES] + ["rules".startswith(starts)] * len(KINDS))


TOLD_TOGETHER = np.stack(
    [
        _named("offset_", "curvature", "normal_spread", "crowding"), _named("offset", "distance", "normal_agreement"),
        _named("normal_", "gap_"), _named("rest_"), _named("part_"), _named("station", "around_"), _named("slice_"),
        _named("typical_"), _named("border", "height_"), _named("rules"),
    ]
)  # fmt: skip
"""Inputs that are left out together of a network of kinds, bool, shape [10, F + 5]."""
OF_LIMBS = _named("offset", "distance", "slice_20", "slice_50", "slice_80", "slice_both")[: -len(KINDS)]
OF_LIMBS &= ~_named("offset_spread", "offset_step")[: -len(KINDS)]
"""Features that grow with the offset from one limb, of which each is fitted well or badly by itself."""


def load_set(folder: Path) -> list[Described]:
    """Read the described scans of the present layout."""
    scans = [load_described(path) for path in sorted(folder.glob("*.npz"))]
    return [scan for scan in scans if scan.about["version"] == FEATURE_LAYOUT_VERSION]


def split(scans: list[Described]) -> tuple[list[Described], list[Described]]:
    """Return the scans to train on, and those of persons kept for validation."""
    kept = [scan.about["seed"] % VALIDATED == VALIDATED - 1 for scan in scans]
    train = [scan for scan, out in zip(scans, kept, strict=True) if not out]
    return train, [scan for scan, out in zip(scans, kept, strict=True) if out]


def cells_of(scan: Described, take: np.ndarray | slice = slice(None)) -> tuple[torch.Tensor, ...]:
    """Return the cells of some samples."""
    front, side = front_and_side(scan, take)
    return to_torch(LimbCells.of(scan.limb[take], scan.station[take], front, side))


def front_and_side(scan: Described, take: np.ndarray | slice = slice(None)) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions of some samples around their limb."""
    front, side = (scan.values[take, FEATURE_NAMES.index(name)] for name in ("around_front", "around_side"))
    return front, side


def inputs_of(scan: Described, of_kinds: bool) -> np.ndarray:
    """Return what a network of kinds, or else one of parts, reads of a scan."""
    return scan.kind_inputs if of_kinds else scan.inputs


def train_network(
    scans: list[Described],
    epochs: int,
    seed: int = 0,
    of_kinds: bool = False,
    start: learnt.Network | None = None,
) -> PersonNetwork:
    """Train a network.

    Args:
        scans: What to train on.
        epochs: Times that each scan is seen.
        seed: Of the weights and of the order.
        of_kinds: Tell `KINDS` apart, and not parts.
        start: A network to go on from, or None to begin with random weights.
    """
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    network = begin_network([inputs_of(scan, of_kinds) for scan in scans], of_kinds, start)
    rate = RATE if start is None else RATE_AGAIN
    optimiser = torch.optim.AdamW(network.parameters(), lr=rate, weight_decay=1e-2)
    steps = max(1, epochs * len(scans) // TOGETHER)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps + 1, pct_start=0.15)
    count = np.bincount(np.concatenate([COLUMN[scan.label] for scan in scans]), minlength=len(PARTS))
    weight = torch.from_numpy((count.max() / np.maximum(count, 1)).clip(max=100) ** 0.25).float()
    order = np.concatenate([rng.permutation(len(scans)) for _ in range(epochs)])[: steps * TOGETHER]
    network.train()
    for step, chosen in enumerate(np.array_split(order, steps)):
        optimiser.zero_grad()
        total = 0.0
        for at in chosen:
            loss = _loss(network, scans[at], weight, rng) / len(chosen)
            loss.backward()
            total += float(loss.detach())
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimiser.step()
        schedule.step()
        if step % 50 == 0:
            print(f"step {step} of {steps}: loss {total:.3f}", flush=True)
    return network.eval()


def begin_network(inputs: list[np.ndarray], of_kinds: bool, start: learnt.Network | None) -> PersonNetwork:
    """Return the network that training begins with; heads that only training uses begin with random weights.

    Args:
        inputs: What it reads of each scan.
        of_kinds: It tells `KINDS` apart, and not parts.
        start: The network to go on from, scaling of the inputs included, or None.
    """
    if start is not None:
        network = PersonNetwork(start.weights["mean"], start.weights["spread"], of_kinds)
        kept = {name: torch.from_numpy(value) for name, value in start.weights.items()}
        network.load_state_dict(network.state_dict() | kept)
        return network
    every = np.concatenate([values[:: max(1, len(values) // 500)] for values in inputs])
    return PersonNetwork(every.mean(axis=0), every.std(axis=0) + 1e-3, of_kinds)


def _loss(network: PersonNetwork, scan: Described, weight: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Return the loss of one scan on drawn samples.

    Cross entropy of the parts; Gaussian likelihood of log tightness; distance to the border; cross entropy of which
    garments there are. Only the first is what the separation reads, the others teach it what cloth is.
    """
    take = rng.choice(len(scan.label), min(SAMPLES, len(scan.label)), replace=False)
    values, lost = _vary(inputs_of(scan, network.of_kinds)[take], rng), rng.random(network.mean.shape[0]) < FORGOTTEN
    if network.of_kinds:
        values = _vary_limbs(values, scan.limb[take], rng)
        lost |= TOLD_TOGETHER[rng.random(len(TOLD_TOGETHER)) < FORGOTTEN].any(axis=0)
    logits, tightness, border, present = network(
        torch.where(torch.from_numpy(lost), network.mean, torch.from_numpy(values)), cells_of(scan, take)
    )
    column = torch.from_numpy(COLUMN[scan.label[take]])
    if not network.of_kinds:
        loss = functional.cross_entropy(logits, column, weight)
    else:  # the likelihood itself, so that probabilities are true
        kinds = torch.from_numpy(np.log(parts_to_kinds(scan.rules[take])).astype(np.float32))
        loss = functional.cross_entropy(kinds + logits, torch.from_numpy(KIND_OF_COLUMN)[column])
    wanted = torch.from_numpy(np.log(scan.tightness[take] + LEAST_TIGHTNESS).astype(np.float32))
    spread = tightness[:, 1].clamp(-3, 3)
    loss = loss + 0.1 * (0.5 * ((tightness[:, 0] - wanted) * torch.exp(-spread)) ** 2 + spread).mean()
    near = torch.from_numpy(np.minimum(scan.border[take], BORDER).astype(np.float32)) / BORDER
    loss = loss + 0.2 * (border - near).abs().mean()
    worn = torch.tensor([float((scan.label == int(part)).mean() > 0.005) for part in GARMENTS])
    return loss + 0.1 * functional.binary_cross_entropy_with_logits(present, worn)


def _vary(values: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return features as another fit would have given them: the body a little thinner or thicker, and grain."""
    raised = OFFSETS[: values.shape[1]] * np.float32(rng.normal(0.0, THICKER) / FEATURE_LENGTH_SCALE)
    return values + raised + rng.normal(0.0, GRAIN, values.shape).astype(np.float32)


def _vary_limbs(values: np.ndarray, limb: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return inputs of a network of kinds as where the fit is off on single limbs, and by parts of the body."""
    count = len(OF_LIMBS)
    raised = rng.normal(0.0, THICKER / FEATURE_LENGTH_SCALE, len(Limb))[limb][:, None] * OF_LIMBS
    raised += rng.normal(0.0, THICKER / FEATURE_LENGTH_SCALE, count) * _named("typical_")[:count]
    return values + np.pad(raised, ((0, 0), (0, len(KINDS)))).astype(np.float32)


def predict(network: PersonNetwork, scan: Described) -> np.ndarray:
    """Return the logits of all samples of a scan, shape [n, 8]; of a network of kinds of `KINDS`, shape [n, 5]."""
    with torch.no_grad():
        logits = network(torch.from_numpy(inputs_of(scan, network.of_kinds)), cells_of(scan))[0].numpy()
    return logits + np.log(parts_to_kinds(scan.rules)) if network.of_kinds else logits


def soften(logits: np.ndarray, temperature: float) -> np.ndarray:
    """Return the posterior of logits at a temperature."""
    return learnt.softmax(logits / temperature)


def calibrate(logits: list[np.ndarray], scans: list[Described]) -> float:
    """Return the temperature for the logits of validated scans; 1 where there are none."""
    if not scans:
        return 1.0
    column = COLUMN[np.concatenate([scan.label for scan in scans])]
    every = np.concatenate(logits)
    return find_temperature(every, KIND_OF_COLUMN[column] if every.shape[1] == len(KINDS) else column)


def measure(logits: list[np.ndarray], temperature: float, scans: list[Described]) -> Judged:
    """Return the figures of a set of scans; garments of a network of kinds are shared out as the rules do."""
    found = [soften(one, temperature) for one in logits]
    if found and found[0].shape[1] == len(KINDS):
        found = [kinds_to_parts(one, scan.share) for one, scan in zip(found, scans, strict=True)]
    return judge(found, [scan.label for scan in scans])


def main() -> None:
    """Train and measure."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--samples", type=Path, required=True, help="folder of described scans")
    parser.add_argument("--held-out", type=Path, nargs="*", default=[], help="folders to measure on alone")
    parser.add_argument("--out", type=Path, required=True, help="folder for weights.npz and weights.json")
    parser.add_argument("--epochs", type=int, default=20)
    parser.add_argument("--persons", type=int, help="train on so many persons at most")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--start", type=Path, help="weights.npz of a training to go on from")
    parser.add_argument("--boosted", action="store_true", help="train the boosted baseline, too (needs scikit-learn)")
    options = parser.parse_args()
    train, validation = split(load_set(options.samples))
    chosen = sorted({scan.about["seed"] for scan in train})[: options.persons]
    train = [scan for scan in train if scan.about["seed"] in chosen]
    sets = {"validation": validation}
    sets |= {folder.name: load_set(folder) for folder in options.held_out}
    options.out.mkdir(parents=True, exist_ok=True)
    start = time.process_time()
    begin = None if options.start is None else load_network(options.start)
    if options.start is not None and begin is None:
        parser.error(f"{options.start} has no weights of the present features; train them anew.")
    network = train_network(train, options.epochs, options.seed, start=begin)
    figures: dict[str, Any] = {"network": {"seconds": time.process_time() - start}}
    logits = {name: [predict(network, scan) for scan in scans] for name, scans in sets.items()}
    temperature = calibrate(logits["validation"], validation)
    figures["network"] |= {
        name: asdict(measure(logits[name], temperature, scans)) for name, scans in sets.items() if scans
    }
    if options.boosted:
        start = time.process_time()
        trees = train_boosted(train, options.seed)
        save_boosted(trees, options.out)
        figures["boosted"] = {"seconds": time.process_time() - start}
        logits = {name: [predict_boosted(trees, scan) for scan in scans] for name, scans in sets.items()}
        cooled = calibrate(logits["validation"], validation)
        figures["boosted"] |= {
            name: asdict(measure(logits[name], cooled, scans)) for name, scans in sets.items() if scans
        }
    about = {
        "seed": options.seed,
        "generator": REVISION,
        "persons": len({scan.about["seed"] for scan in train}),
        "scans": len(train),
        "epochs": options.epochs,
        "temperature": temperature,
        "figures": figures,
    }
    save_weights(network, temperature, options.out / "weights.npz", about)
    print(json.dumps(about, indent=1))


if __name__ == "__main__":
    main()
