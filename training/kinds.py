"""Train the networks that ship: `python -m garmentq.training.kinds --samples DIR DIR --out FILE.npz`.

They tell skin, hair, shoes, garments and other things apart, are alike but for the seed, and answer together. What
they are worth is measured by `compare.py --kinds FILE.npz`.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from ..core.people.features import FEATURE_LAYOUT_VERSION
from ..core.people.networks import LimbCells, Network, NetworkEnsemble, kinds_to_parts, load_ensemble, parts_to_kinds
from .describe import Described
from .judge import Judged, judge
from .network import PersonNetwork
from .persons import REVISION
from .train import calibrate, front_and_side, load_set, predict, split, train_network

SEEDS = (0, 1)
"""Of the networks: two are 0.5 MB."""

TRAINING_HEADS = ("tightness", "border", "present")
"""Heads that only training uses."""


def harden(network: PersonNetwork, temperature: float) -> Network:
    """Return a trained network as numpy runs it: matrices in half precision."""
    state = {name: value.numpy() for name, value in network.state_dict().items()}
    exact = ("mean", "spread")
    weights = {k: v if k in exact else v.astype(np.float16).astype(np.float32) for k, v in state.items()}
    return Network(weights, temperature)


def measure_committee(committee: NetworkEnsemble, scans: list[Described]) -> Judged:
    """Return the figures of networks of kinds on scans, garments shared out as the rules do."""
    found = []
    for scan in scans:
        cells = LimbCells.of(scan.limb, scan.station, *front_and_side(scan))
        found.append(kinds_to_parts(committee.predict(scan.kind_inputs, parts_to_kinds(scan.rules), cells), scan.share))
    return judge(found, [scan.label for scan in scans])


def write_kinds(committee: NetworkEnsemble, path: Path, about: dict[str, Any]) -> None:
    """Write networks of kinds, and beside them what is known of them with the file's hash."""
    save_ensemble(committee, path)
    count = sum(value.size for each in committee.networks for value in each.weights.values())
    known = {
        "sha256": sha256(path.read_bytes()).hexdigest(),
        "features": FEATURE_LAYOUT_VERSION,
        "parameters": count,
        **about,
    }
    path.with_suffix(".json").write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    """Train, measure on the persons that were kept, and write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--samples", type=Path, nargs="+", required=True, help="folders of described scans")
    parser.add_argument("--out", type=Path, required=True, help="the file, kinds.npz")
    parser.add_argument("--epochs", type=int, default=16)
    parser.add_argument("--start", type=Path, help="networks of kinds to go on from, one for each seed")
    parser.add_argument("--seeds", type=int, nargs="*", default=SEEDS)
    options = parser.parse_args()
    train, validation = split([scan for folder in options.samples for scan in load_set(folder)])
    begin: Sequence[Network | None] = [None] * len(options.seeds)
    if options.start is not None:
        begin = load_ensemble(options.start).networks
    members = []
    for seed, start in zip(options.seeds, begin, strict=True):
        network = train_network(train, options.epochs, seed, of_kinds=True, start=start)
        members.append(harden(network, calibrate([predict(network, scan) for scan in validation], validation)))
    committee = NetworkEnsemble(tuple(members))
    about = describe_training(committee, options.seeds, options.epochs, train, validation)
    if options.start is not None:
        about["start"] = sha256(options.start.read_bytes()).hexdigest()
    write_kinds(committee, options.out, about)


def describe_training(
    committee: NetworkEnsemble, seeds: list[int], epochs: int, train: list[Described], validation: list[Described]
) -> dict[str, Any]:
    """Return what is written beside the weights: how they were made, and their figures on the persons kept."""
    return {
        "seeds": list(seeds),
        "generator": REVISION,
        "persons": len({scan.about["seed"] for scan in train}),
        "scans": len(train),
        "epochs": epochs,
        "temperatures": [each.temperature for each in committee.networks],
        "kept": asdict(measure_committee(committee, validation)) if validation else None,
    }


def save_ensemble(committee: NetworkEnsemble, path: Path) -> None:
    """Write networks of kinds as one file: matrices in half precision, `0.first.weight`, without training heads."""
    arrays: dict[str, np.ndarray] = {"version": np.array(FEATURE_LAYOUT_VERSION)}
    for i, network in enumerate(committee.networks):
        arrays[f"{i}.temperature"] = np.array(network.temperature)
        for name, value in network.weights.items():
            if name.split(".")[0] not in TRAINING_HEADS:
                arrays[f"{i}.{name}"] = value if name in ("mean", "spread") else value.astype(np.float16)
    np.savez_compressed(path, **arrays)  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
