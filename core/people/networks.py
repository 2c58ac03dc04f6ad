"""Predict skin, hair, shoes, garments and other things by small trained networks, in numpy.

A perceptron reads every sample's features and the rules' posterior; its output is pooled over the cells of the unrolled
limbs (stations of 2 cm, four sectors around), filtered along them, joined with the opposite limb and the whole person,
and returned to the samples. Which garment it is follows from the rules (`tell_by_rules`), as the persons of the
training do not wear all that is worn. `training/` makes the weights.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np

from ..run.errors import GarmentqError
from .features import FEATURE_LAYOUT_VERSION, Features
from .limbs import Limb
from .part import GARMENTS, PARTS, Part
from .points import FittedPerson, PersonPoints
from .rules import tell_by_rules

NETWORK_FILE = Path(__file__).parent / "kinds.npz"
"""The shipped networks; `kinds.json` beside them has hash, seeds, generator and figures."""
LIMB_CELL_LENGTH = 0.02
"""Length of a cell along a limb [m]: three samples, and half a hem's step."""
FIRST_CELL_STATION = -0.12
"""Station at which the first cell of a limb begins [m]: armpits and crotch are before their limb's joint."""
LIMB_STATION_COUNT = 62
"""Number of cells along a limb: to 1.12 m, a leg of a person of 2.10 m."""
LIMB_SECTOR_COUNT = 4
"""Number of sectors around a limb: front, back, and the two sides."""
OPPOSITE_LIMBS = (Limb.TRUNK, Limb.NECK, Limb.RIGHT_ARM, Limb.LEFT_ARM, Limb.RIGHT_LEG, Limb.LEFT_LEG)
"""The limb on the other side of each of `Limb`."""
LIMB_GROUPS = ((Limb.TRUNK,), (Limb.NECK,), (Limb.LEFT_ARM, Limb.RIGHT_ARM), (Limb.LEFT_LEG, Limb.RIGHT_LEG))
"""Limbs that are averaged together for the whole person."""
EXCHANGE_ROUND_COUNT = 2
"""Number of rounds in which samples, cells and the whole person exchange features."""
FILTER_DILATIONS = (1, 3)
"""Distances between the five taps of the two filters along a limb [cells]: they reach 4 and 12 cm to either side."""
MAX_FEATURE_DEVIATION = 8.0
"""Number of standard deviations at which features are clamped, so that an unusual scan stays in the trained range."""
MIN_RULE_PROBABILITY = 1.0e-3
"""Least probability by the rules in the networks' input, before their logarithm is taken."""
RECTIFIER_SLOPE = 0.1
"""Slope [1] of the leaky rectifier below zero."""
KINDS: tuple[tuple[Part, ...], ...] = ((Part.SKIN,), (Part.HAIR,), (Part.SHOES,), GARMENTS, (Part.OTHER,))
"""Classes of a network of kinds: any garment is one kind."""
KIND_OF_COLUMN = np.array([next(k for k, kind in enumerate(KINDS) if part in kind) for part in PARTS])
"""Index in `KINDS` of each column of a posterior."""
GARMENT_KIND = int(KIND_OF_COLUMN[PARTS.index(Part.UPPER)])
"""Index of garments in `KINDS`."""
BARE_KINDS = [int(KIND_OF_COLUMN[PARTS.index(part)]) for part in (Part.SKIN, Part.SHOES)]
"""Indices of the kinds beyond the ends of garments."""
MAX_LOG_ODDS_CHANGE = float(np.log(50.0))
"""Largest change by the networks [1] of the log-odds of skin, or shoes, to garments: like colour, they count against
garments by 1 : 50 at most. They took a smooth sheet 12 mm over the legs for skin and boots, however sure the rules
were, as no person of the training wears anything so close. The rules are less sure of hair and other things."""
MIN_KIND_PROBABILITY = 1e-12
"""Least probability of a kind before its logarithm is taken."""


@dataclass(frozen=True)
class LimbCells:
    """Describe the cell of the unrolled limbs that each sample is in.

    Attributes:
        index: The cell, int64, shape [n].
        low: The cell before the sample's station, shape [n].
        high: The cell after it, shape [n].
        share: Weight of `high` when values of cells are interpolated, shape [n].
    """

    index: np.ndarray
    low: np.ndarray
    high: np.ndarray
    share: np.ndarray

    @classmethod
    def of(cls, limb: np.ndarray, station: np.ndarray, front: np.ndarray, side: np.ndarray) -> LimbCells:
        """Find the cells of samples from their limb, station [m], and the directions around it, shape [n] each."""
        sector = np.where(np.abs(front) >= np.abs(side), np.where(front >= 0, 0, 1), np.where(side >= 0, 2, 3))
        row = (limb.astype(np.int64) * LIMB_SECTOR_COUNT + sector) * LIMB_STATION_COUNT
        along = np.clip((station - FIRST_CELL_STATION) / LIMB_CELL_LENGTH, 0.0, LIMB_STATION_COUNT - 1e-3)
        before = np.clip(np.floor(along - 0.5), 0, LIMB_STATION_COUNT - 2).astype(np.int64)
        share = np.clip(along - 0.5 - before, 0.0, 1.0)
        return cls(row + np.floor(along).astype(np.int64), row + before, row + before + 1, share.astype(np.float32))


TOTAL_CELL_COUNT = len(Limb) * LIMB_SECTOR_COUNT * LIMB_STATION_COUNT
"""Number of cells."""


def find_limb_cells(features: Features) -> LimbCells:
    """Find the cells of described samples."""
    place = features.place
    return LimbCells.of(place.limb, place.station, features.column("around_front"), features.column("around_side"))


def network_inputs(values: np.ndarray, rules: np.ndarray) -> np.ndarray:
    """Return a network's input: features, shape [n, F], and logarithms of the rules' posterior, shape [n, k]."""
    return np.hstack([values, np.log(np.maximum(rules, MIN_RULE_PROBABILITY))]).astype(np.float32)


def parts_to_kinds(posterior: np.ndarray) -> np.ndarray:
    """Return the probability of each of `KINDS`, shape [n, 5], from that of each part, shape [n, 8]."""
    return np.stack([posterior[:, KIND_OF_COLUMN == k].sum(axis=1) for k in range(len(KINDS))], axis=1)


def kinds_to_parts(kinds: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the posterior of the parts, shape [n, 8], from that of `KINDS`, shape [n, 5].

    Args:
        kinds: Rows sum to 1.
        share: Probability of each garment if the sample is one, as `RulesTold.share`, shape [n, 8].
    """
    return np.asarray(kinds[:, KIND_OF_COLUMN] * np.where(KIND_OF_COLUMN == GARMENT_KIND, share, 1.0))


@dataclass(frozen=True)
class Network:
    """Describe a trained network.

    Attributes:
        weights: Arrays by name: `mean` and `spread` of the features, matrices and biases of the layers.
        temperature: Divisor of the logits that makes probabilities true.
    """

    weights: dict[str, np.ndarray]
    temperature: float

    def logits(self, values: np.ndarray, cells: LimbCells) -> np.ndarray:
        """Compute the logits of each sample, divided by the temperature, shape [n, heads].

        Args:
            values: The input (`network_inputs`), shape [n, inputs].
            cells: Where the samples are.
        """
        return np.asarray(self._apply("part", self.embed(values, cells)) / self.temperature)

    def embed(self, values: np.ndarray, cells: LimbCells) -> np.ndarray:
        """Compute the input of the heads, shape [n, width]."""
        w = self.weights
        hidden: np.ndarray = np.clip((values - w["mean"]) / w["spread"], -MAX_FEATURE_DEVIATION, MAX_FEATURE_DEVIATION)
        hidden = _leaky_relu(self._apply("second", _leaky_relu(self._apply("first", hidden))))
        pooling = _Pooling.of(cells)
        for turn in range(EXCHANGE_ROUND_COUNT):
            hidden = hidden + self._exchange(f"round{turn}", hidden, cells, pooling)
        return hidden

    def _exchange(self, name: str, hidden: np.ndarray, cells: LimbCells, pooling: _Pooling) -> np.ndarray:
        """Pool samples to cells, filter along limbs, join with opposite limb and whole, and return to samples."""
        width = hidden.shape[1]
        cell = _leaky_relu(self._apply(f"{name}.pool", pooling.pool(hidden)))
        cell = cell.reshape(len(Limb), LIMB_SECTOR_COUNT, LIMB_STATION_COUNT, width)
        slices = np.broadcast_to(cell.mean(axis=1, keepdims=True), cell.shape)
        other = slices[list(OPPOSITE_LIMBS)]
        cell = _leaky_relu(self._apply(f"{name}.mix", np.concatenate([cell, slices, other], axis=-1)))
        for i, dilation in enumerate(FILTER_DILATIONS):
            cell = cell + _leaky_relu(self._filter(f"{name}.along{i}", cell, dilation))
        weight = pooling.full.reshape(len(Limb), LIMB_SECTOR_COUNT, LIMB_STATION_COUNT, 1)
        sums = [(cell[list(group)] * weight[list(group)]).sum(axis=(0, 1, 2)) for group in LIMB_GROUPS]
        counts = [max(float(weight[list(group)].sum()), 1.0) for group in LIMB_GROUPS]
        whole = np.concatenate([total / count for total, count in zip(sums, counts, strict=True)])
        whole = _leaky_relu(self._apply(f"{name}.whole1", _leaky_relu(self._apply(f"{name}.whole0", whole))))
        flat = cell.reshape(-1, width)
        interpolated = flat[cells.low] * (1 - cells.share[:, None]) + flat[cells.high] * cells.share[:, None]
        joined = np.concatenate([hidden, interpolated, np.broadcast_to(whole, hidden.shape)], axis=1)
        return self._apply(f"{name}.back1", _leaky_relu(self._apply(f"{name}.back0", joined)))

    def _apply(self, name: str, values: np.ndarray) -> np.ndarray:
        return np.asarray(values @ self.weights[f"{name}.weight"].T + self.weights[f"{name}.bias"])

    def _filter(self, name: str, cell: np.ndarray, dilation: int) -> np.ndarray:
        """Filter along the stations with five taps, zero beyond the ends; weight of shape [out, in, 5]."""
        taps, bias = self.weights[f"{name}.weight"], self.weights[f"{name}.bias"]
        reach = dilation * (taps.shape[2] // 2)
        padded = np.pad(cell, ((0, 0), (0, 0), (reach, reach), (0, 0)))
        shifted = (
            padded[:, :, k * dilation : k * dilation + LIMB_STATION_COUNT] @ taps[:, :, k].T
            for k in range(taps.shape[2])
        )
        return np.asarray(sum(shifted) + bias)


@dataclass(frozen=True)
class NetworkEnsemble:
    """Describe networks of kinds, the members, that were trained alike but for the seed."""

    networks: tuple[Network, ...]

    def predict_kinds(self, features: Features, rules: np.ndarray) -> np.ndarray:
        """Compute the posterior of `KINDS`, rows sum to 1, shape [n, 5].

        Args:
            features: The samples' features.
            rules: The posterior by rules, shape [n, 8].
        """
        kinds = parts_to_kinds(rules)
        return self.predict(network_inputs(features.values, kinds), kinds, find_limb_cells(features))

    def predict(self, values: np.ndarray, kinds: np.ndarray, cells: LimbCells) -> np.ndarray:
        """Compute the geometric mean of the members' posteriors; each is the rules' times a learnt factor.

        Args:
            values: A network's input, shape [n, inputs].
            kinds: The rules' posterior of `KINDS`, shape [n, 5].
            cells: Where the samples are.
        """
        logits = [np.log(kinds) / each.temperature + each.logits(values, cells) for each in self.networks]
        return limit_log_odds_change(softmax(np.mean(logits, axis=0)), kinds)


def limit_log_odds_change(posterior: np.ndarray, rules: np.ndarray) -> np.ndarray:
    """Clamp a posterior's log-odds of skin, and shoes, to garments within `MAX_LOG_ODDS_CHANGE` of the rules'.

    Args:
        posterior: Of `KINDS`, shape [n, 5].
        rules: The rules', shape [n, 5].
    """
    log = np.log(np.maximum(posterior, MIN_KIND_PROBABILITY))
    # The lower probability is raised instead of lowering the higher one: else the other kinds would gain.
    change = (log - np.log(rules))[:, BARE_KINDS] - (log - np.log(rules))[:, [GARMENT_KIND]]
    raised = np.maximum(change.max(axis=1) - MAX_LOG_ODDS_CHANGE, 0.0)
    log[:, GARMENT_KIND] += raised
    log[:, BARE_KINDS] += np.maximum(-MAX_LOG_ODDS_CHANGE - (change - raised[:, None]), 0.0)
    return softmax(log)


@dataclass(frozen=True)
class _Pooling:
    """Describe how samples are pooled: order by cell, begin, index and count of filled cells, and which are full."""

    order: np.ndarray
    begin: np.ndarray
    cell: np.ndarray
    count: np.ndarray
    full: np.ndarray

    @classmethod
    def of(cls, cells: LimbCells) -> _Pooling:
        """Sort samples by cell."""
        order = np.argsort(cells.index, kind="stable")
        cell, begin, count = np.unique(cells.index[order], return_index=True, return_counts=True)
        full = np.zeros((TOTAL_CELL_COUNT, 1), np.float32)
        full[cell] = 1.0
        return cls(order, begin, cell, count, full)

    def pool(self, hidden: np.ndarray) -> np.ndarray:
        """Compute mean and maximum in each cell, 0 in empty ones, and which are full, shape [cells, 2 * width + 1]."""
        sorted_ = hidden[self.order]
        mean = np.zeros((TOTAL_CELL_COUNT, hidden.shape[1]), hidden.dtype)
        highest = np.zeros_like(mean)
        mean[self.cell] = np.add.reduceat(sorted_, self.begin) / self.count[:, None]
        highest[self.cell] = np.maximum.reduceat(sorted_, self.begin)
        return np.concatenate([mean, highest, self.full], axis=1)


def softmax(logits: np.ndarray) -> np.ndarray:
    """Return the posterior of logits, shape [n, k]."""
    chance = np.exp(logits - logits.max(axis=1, keepdims=True))
    return np.asarray(chance / chance.sum(axis=1, keepdims=True))


def _leaky_relu(values: np.ndarray) -> np.ndarray:
    found: np.ndarray = np.maximum(values, RECTIFIER_SLOPE * values)
    return found


class WrongWeights(GarmentqError):
    """The file of the trained networks is not the one that garmentq was made with; install garmentq anew."""

    code = "segment.wrong_weights"


@cache
def load_ensemble(path: Path = NETWORK_FILE) -> NetworkEnsemble:
    """Read the shipped networks.

    Raises:
        WrongWeights: where the file is not that of `kinds.json`, or was trained on another layout of features.
    """
    known = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    if sha256(path.read_bytes()).hexdigest() != known["sha256"]:
        raise WrongWeights
    members: dict[str, dict[str, np.ndarray]] = {}
    with np.load(path) as kept:
        if int(kept["version"]) != FEATURE_LAYOUT_VERSION:
            raise WrongWeights
        for key in kept.files:
            member, _, name = key.partition(".")
            if name:
                members.setdefault(member, {})[name] = kept[key].astype(np.float32)
    return NetworkEnsemble(tuple(Network(each, float(each.pop("temperature"))) for each in members.values()))


def predict_by_networks(
    points: PersonPoints, features: Features, fit: FittedPerson, tone: np.ndarray | None, committee: NetworkEnsemble
) -> np.ndarray:
    """Compute the posterior of the parts: kinds by rules and networks together, garments by the rules alone.

    Args:
        points: The samples.
        features: Their features.
        fit: The body fitted below the clothes; the networks were trained on such fits alone.
        tone: Evidence for skin by its colour (`skin_evidence`), shape [n], or None.
        committee: The networks.

    Returns:
        Probabilities in the order of `PARTS`, rows sum to 1, shape [n, 8].
    """
    rules = tell_by_rules(points, features, fit, tone)
    return kinds_to_parts(committee.predict_kinds(features, rules.posterior), rules.share)
