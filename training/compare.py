"""Compare rules, trees and network on described scans: `python -m garmentq.training.compare`.

All answer on the same samples and fits: as they are, and `told`, after all that a separation does with a posterior,
which is what a user gets.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from ..core.person.colour import use_colours
from ..core.person.confidence import leave_foreign
from ..core.person.crumbs import give_crumbs
from ..core.person.diffusion import diffuse, link_points
from ..core.person.features import Features, describe_points
from ..core.person.outfit import above_waist, rank_outfits, read_all, read_as
from ..core.person.points import PersonPoints, sample_person
from ..core.person.rules import predict_by_rules
from .boosted import load_boosted, predict_boosted
from .describe import Described, load_described, painted_scan, unpack_fit
from .judge import NUMBERS, judge_labels
from .runtime import Network, load_network
from .shards import load_shard


@dataclass
class Answers:
    """What was found on the scans so far, by one name.

    Attributes:
        labels: Of each scan.
        confidences: Of each label.
    """

    labels: list[np.ndarray] = field(default_factory=list)
    confidences: list[np.ndarray] = field(default_factory=list)


def answer(shard: Path, described: Described, learners: Learners) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the labels and their confidence on one scan by the name of who answers."""
    raw, fit = painted_scan(load_shard(shard)), unpack_fit(described.state)
    points = sample_person(raw, fit)
    features = describe_points(points, fit)
    rules = predict_by_rules(points, features, fit)
    found = {"rules": rules} | learners.predict(features, replace(described, rules=rules))
    above = above_waist(features.place, fit.body)
    answers = {name: (NUMBERS[each.argmax(axis=1)], each.max(axis=1)) for name, each in found.items()}
    return answers | {f"{name}_told": tell(each, points, features, above) for name, each in found.items()}


def tell(
    posterior: np.ndarray, points: PersonPoints, features: Features, above: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the labels and their confidence that a separation makes of a posterior of the samples."""
    links = link_points(points.positions, points.normals)
    posterior = diffuse(posterior, links)
    if points.colours is not None:
        posterior = use_colours(posterior, points.colours, features.place, links)
    outfits = rank_outfits(posterior, above)
    believed, read = read_all(posterior, outfits, above), read_as(posterior, outfits[0].parts, above)
    first = read.argmax(axis=1)
    column = give_crumbs(first, points.positions, np.full(len(first), points.spacing**2), links)
    rows = np.arange(len(column))
    # A crumb that was given away is as sure as what it was taken for.
    return NUMBERS[column], leave_foreign(believed)[rows, first]


@dataclass(frozen=True)
class Learners:
    """What was trained.

    Attributes:
        network: Or None.
        trees: Boosted trees, or None.
    """

    network: Network | None
    trees: object | None

    @classmethod
    def load(cls, folder: Path | None) -> Learners:
        """Read what a training left in a folder; without one, nothing was trained."""
        return cls(None, None) if folder is None else cls(load_network(folder / "weights.npz"), load_boosted(folder))

    def predict(self, features: Features, described: Described) -> dict[str, np.ndarray]:
        """Return the posteriors by name."""
        found = {}
        if self.network is not None:
            found["network"] = self.network.predict(features, described.rules)
        if self.trees is not None:
            logits = predict_boosted(self.trees, described)
            found["boosted"] = np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True)
        return found


def compare(persons: Path, samples: Path, learners: Learners) -> dict[str, dict]:
    """Return the figures of everybody who answers on the described scans of a folder."""
    answers: dict[str, Answers] = {}
    labels = []
    for path in sorted(samples.glob("*.npz")):
        described = load_described(path)
        found = answer(persons / path.name, described, learners)
        if len(found["rules"][0]) != len(described.label):  # another version of the samples
            continue
        labels.append(described.label)
        for name, (label, confidence) in found.items():
            own = answers.setdefault(name, Answers())
            own.labels.append(label)
            own.confidences.append(confidence)
    return {name: asdict(judge_labels(own.labels, own.confidences, labels)) for name, own in answers.items()} | {
        "scans": {"count": len(labels)}
    }


def main() -> None:
    """Print the comparison as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--persons", type=Path, required=True, help="folder of scans")
    parser.add_argument("--samples", type=Path, required=True, help="folder of their described samples")
    parser.add_argument("--weights", type=Path, help="folder that a training wrote; none: the rules alone")
    options = parser.parse_args()
    print(json.dumps(compare(options.persons, options.samples, Learners.load(options.weights)), indent=1))


if __name__ == "__main__":
    main()
