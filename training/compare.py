"""Compare rules, trees and networks on described scans: `python -m garmentq.training.compare`.

All answer on the same samples and fits: as they are, and `told`, after all that a separation does with a posterior,
which is what a user gets. What is told is also judged on the scans by what is worn: without an outer layer, and of
those with the outfit read rightly and wrongly.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ..core.people.coat import Coat, find_coat
from ..core.people.colour import link_alike
from ..core.people.diffusion import Links, link_points
from ..core.people.features import Features, describe_points
from ..core.people.networks import (
    Network,
    NetworkEnsemble,
    find_limb_cells,
    kinds_to_parts,
    load_ensemble,
    network_inputs,
    parts_to_kinds,
    softmax,
)
from ..core.people.outfit import (
    above_waist_probability,
    condition_on_outfit,
    marginalise_outfits,
    outfit_probabilities,
    rank_outfits,
)
from ..core.people.part import GARMENTS, Part
from ..core.people.points import PersonPoints, sample_person
from ..core.people.rules import tell_by_rules
from ..core.people.separate import smooth_parts
from ..core.people.small_pieces import relabel_small_pieces
from ..core.people.tone import skin_evidence
from .boosted import load_boosted, predict_boosted
from .describe import Described, load_described, painted_scan, unpack_fit
from .judge import NUMBERS, judge_labels
from .network import load_network
from .shards import load_shard
from .waists import PRESENT


@dataclass(frozen=True)
class Answer:
    """What was found on one scan by one name.

    Attributes:
        label: Of each sample.
        confidence: Of each label.
        outfit: The garments of the best reading, and None where none was chosen.
        likely: Its probability.
    """

    label: np.ndarray
    confidence: np.ndarray
    outfit: frozenset[Part] | None = None
    likely: float = 0.0


def answer(shard: Path, described: Described, learners: Learners) -> dict[str, Answer]:
    """Return the answers on one scan by the name of who answers."""
    raw, fit = painted_scan(load_shard(shard)), unpack_fit(described.state)
    points = sample_person(raw, fit)
    features = describe_points(points, fit)
    tone = None if points.lab is None else skin_evidence(points.lab, features.place, fit.body)
    rules, share = tell_by_rules(points, features, fit, tone)
    found = {"rules": rules} | learners.predict(features, described, rules, share)
    links = link_points(points.positions, points.normals)
    if points.lab is not None:
        links = link_alike(links, points.lab)
    above = above_waist_probability(features.place, fit.body)
    answers = {name: Answer(NUMBERS[each.argmax(axis=1)], each.max(axis=1)) for name, each in found.items()}
    for name, each in found.items():
        smooth = smooth_parts(each, points, features, links, tone)
        coat = find_coat(points, features, smooth, links, fit.body)
        answers[f"{name}_told"] = tell(smooth, points, links, above, coat)
    return answers


def tell(posterior: np.ndarray, points: PersonPoints, links: Links, above: np.ndarray, coat: Coat) -> Answer:
    """Return the labels and their confidence that a separation makes of a smoothed posterior of the samples."""
    outfits = rank_outfits(posterior, above, coat=coat)
    believed = marginalise_outfits(posterior, outfits, above, coat.over)
    read = condition_on_outfit(posterior, outfits[0].parts, above, coat.over)
    first = read.argmax(axis=1)
    column = relabel_small_pieces(first, points.positions, np.full(len(first), points.spacing**2), links)
    # A crumb that was given away is as sure as what it was taken for.
    confidence = believed[np.arange(len(column)), first]
    likely = float(outfit_probabilities(outfits)[0])
    return Answer(NUMBERS[column], confidence, frozenset(outfits[0].parts), likely)


@dataclass(frozen=True)
class Learners:
    """What was trained.

    Attributes:
        network: Or None.
        trees: Boosted trees, or None.
        kinds: Networks of kinds, or None.
    """

    network: Network | None
    trees: object | None
    kinds: NetworkEnsemble | None = None

    @classmethod
    def load(cls, folder: Path | None, kinds: Path | None = None) -> Learners:
        """Read what a training left in a folder, and networks of kinds from a file; without, nothing was trained."""
        committee = None if kinds is None else load_ensemble(kinds)
        if folder is None:
            return cls(None, None, committee)
        return cls(load_network(folder / "weights.npz"), load_boosted(folder), committee)

    def predict(
        self, features: Features, described: Described, rules: np.ndarray, share: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return the posteriors by name; `grouped` has a network's or the trees' kinds, and the rules' garments.

        Args:
            features: The samples' description.
            described: The scan, for the trees.
            rules: The rules' posterior, shape [n, 8].
            share: Which garment each sample is by the rules if it is one, shape [n, 8].
        """
        found = {}
        if self.network is not None:
            values = network_inputs(features.values, rules)
            found["network"] = softmax(self.network.logits(values, find_limb_cells(features)))
        if self.trees is not None:
            logits = predict_boosted(self.trees, described)
            found["boosted"] = np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True)
        found |= {f"{name}_grouped": kinds_to_parts(parts_to_kinds(each), share) for name, each in found.items()}
        if self.kinds is not None:
            found["kinds"] = kinds_to_parts(self.kinds.predict_kinds(features, rules), share)
        return found


def compare(persons: Path, samples: Path, learners: Learners) -> dict[str, dict]:
    """Return the figures of everybody who answers on the described scans of a folder."""
    answers: dict[str, list[tuple[Answer, np.ndarray]]] = {}
    count = 0
    for path in sorted(samples.glob("*.npz")):
        described = load_described(path)
        found = answer(persons / path.name, described, learners)
        if len(found["rules"].label) != len(described.label):  # another version of the samples
            continue
        count += 1
        for name, each in found.items():
            answers.setdefault(name, []).append((each, described.label))
    figures = {name: judge_answers(own) for name, own in answers.items()}
    for name, own in answers.items():
        for group, members in split_by_outfit(own).items():
            if members:
                figures[f"{name}, {group}"] = judge_answers(members)
    return figures | {"scans": {"count": count}}


def judge_answers(own: list[tuple[Answer, np.ndarray]]) -> dict:
    """Return the figures of some answers, each with the true labels, and how often the outfit is right and said so."""
    labels = [true for _, true in own]
    figures = asdict(judge_labels([each.label for each, _ in own], [each.confidence for each, _ in own], labels))
    figures["scans"] = len(own)
    figures["confidence"] = float(np.concatenate([each.confidence for each, _ in own]).mean())
    if own[0][0].outfit is not None:
        figures["outfit_right"] = float(np.mean([each.outfit == worn(true) for each, true in own]))
        figures["outfit_said"] = float(np.mean([each.likely for each, _ in own]))
    return figures


def split_by_outfit(own: list[tuple[Answer, np.ndarray]]) -> dict[str, list[tuple[Answer, np.ndarray]]]:
    """Return the answers for which an outfit was chosen, by what is worn and whether that was read."""
    chosen = [each for each in own if each[0].outfit is not None]
    plain = [each for each in chosen if Part.OUTER not in worn(each[1])]
    return {
        "no outer layer": plain,
        "no outer layer, outfit right": [each for each in plain if each[0].outfit == worn(each[1])],
        "no outer layer, outfit wrong": [each for each in plain if each[0].outfit != worn(each[1])],
        "outer layer": [each for each in chosen if Part.OUTER in worn(each[1])],
    }


def worn(label: np.ndarray) -> frozenset[Part]:
    """Return the garments that are worn in truth."""
    return frozenset(part for part in GARMENTS if (label == part).mean() > PRESENT)


def main() -> None:
    """Print the comparison as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--persons", type=Path, required=True, help="folder of scans")
    parser.add_argument("--samples", type=Path, required=True, help="folder of their described samples")
    parser.add_argument("--weights", type=Path, help="folder that a training wrote; none: the rules alone")
    parser.add_argument("--kinds", type=Path, help="file of networks of kinds; the one that ships lies in core/people")
    options = parser.parse_args()
    learners = Learners.load(options.weights, options.kinds)
    print(json.dumps(compare(options.persons, options.samples, learners), indent=1))


if __name__ == "__main__":
    main()
