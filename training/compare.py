"""Compare rules and network on described scans: `python -m garmentq.training.compare --persons DIR --samples DIR`.

Both answer on the same samples and fits, as they are and after the diffusion that a separation does.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ..core.person.diffusion import diffuse, link_points
from ..core.person.features import describe_points
from ..core.person.points import sample_person
from ..core.person.rules import predict_by_rules
from .describe import Described, load_described, unpack_fit
from .judge import judge
from .runtime import Network, load_network
from .shards import load_shard


def answer(shard: Path, described: Described, network: Network | None) -> dict[str, np.ndarray]:
    """Return the posteriors of one scan by the name of who answers, each of shape [n, 8]."""
    raw, fit = load_shard(shard).raw_scan(), unpack_fit(described.state)
    points = sample_person(raw, fit)
    features = describe_points(points, fit)
    found = {"rules": predict_by_rules(points, features, fit)}
    if network is not None:
        found["network"] = network.predict(features, found["rules"])
    links = link_points(points.positions, points.normals)
    return found | {f"{name}_diffused": diffuse(posterior, links) for name, posterior in found.items()}


def compare(persons: Path, samples: Path, weights: Path | None) -> dict[str, dict]:
    """Return the figures of everybody who answers on the described scans of a folder."""
    network = load_network(weights) if weights else None
    answers: dict[str, list[np.ndarray]] = {}
    labels = []
    for path in sorted(samples.glob("*.npz")):
        described = load_described(path)
        found = answer(persons / path.name, described, network)
        if len(found["rules"]) != len(described.label):  # another version of the samples
            continue
        labels.append(described.label)
        for name, posterior in found.items():
            answers.setdefault(name, []).append(posterior)
    return {name: asdict(judge(posteriors, labels)) for name, posteriors in answers.items()} | {
        "scans": {"count": len(labels)}
    }


def main() -> None:
    """Print the comparison as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--persons", type=Path, required=True, help="folder of scans")
    parser.add_argument("--samples", type=Path, required=True, help="folder of their described samples")
    parser.add_argument("--weights", type=Path, help="weights.npz; none: the rules alone")
    options = parser.parse_args()
    print(json.dumps(compare(options.persons, options.samples, options.weights), indent=1))


if __name__ == "__main__":
    main()
