"""Predict the parts of a person by a small trained network, in numpy, as a separation would run it.

Every sample's features and what the rules say of it go through a perceptron; what comes out is pooled over the cells of
the unrolled limbs (stations of 2 cm, four sectors around), filtered along the limbs, joined with the limb on the other
side and with the whole person, and handed back to the samples. `training/` makes the weights.

A network of kinds tells skin, hair, shoes, garments and other things apart; which garment it is stays with the rules
(`share_garments`), since persons that a network was trained on do not show all that is worn. It multiplies the rules'
probabilities by factors whose ratio is bounded (`Network.bound`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..core.person.features import VERSION, Features
from ..core.person.limbs import Limb
from ..core.person.part import GARMENTS, PARTS, Part

STATION = 0.02
"""Length of a cell along a limb [m]: three samples, and half a hem's step."""
START = -0.12
"""Station of the first cell [m]: armpits and crotch lie before their limb's joint."""
STATIONS = 62
"""Cells along a limb: to 1.12 m, a leg of a person of 2.10 m."""
SECTORS = 4
"""Sectors around a limb: front, back, and the two sides."""
PARTNER = (Limb.TRUNK, Limb.NECK, Limb.RIGHT_ARM, Limb.LEFT_ARM, Limb.RIGHT_LEG, Limb.LEFT_LEG)
"""The limb on the other side, of each of `Limb`."""
GROUPS = ((Limb.TRUNK,), (Limb.NECK,), (Limb.LEFT_ARM, Limb.RIGHT_ARM), (Limb.LEFT_LEG, Limb.RIGHT_LEG))
"""Limbs that are summed up together for the whole person."""
ROUNDS = 2
"""Times that samples, cells and the whole person exchange what they know."""
DILATIONS = (1, 3)
"""Distances between the five taps of the two filters along a limb: they see 4 and 12 cm to either side."""
REACH = 8.0
"""Features are clipped to so many standard deviations: an odd scan must not leave the range that was trained."""
LEAST = 1.0e-3
"""Probability that the rules' are not believed below."""
SLOPE = 0.1
"""Slope of the rectifier below zero."""
KINDS: tuple[tuple[Part, ...], ...] = ((Part.SKIN,), (Part.HAIR,), (Part.SHOES,), GARMENTS, (Part.OTHER,))
"""What a network of kinds tells apart: any garment is one kind."""
KIND = np.array([next(k for k, kind in enumerate(KINDS) if part in kind) for part in PARTS])
"""Place in `KINDS` of each column of a posterior."""


@dataclass(frozen=True)
class Cells:
    """Describe in which cell of the unrolled limbs each sample lies.

    Attributes:
        index: The cell, int64, shape [n].
        low: The cell before the sample's station, shape [n].
        high: The cell after it, shape [n].
        share: Share of `high` when what cells know is handed back, shape [n].
    """

    index: np.ndarray
    low: np.ndarray
    high: np.ndarray
    share: np.ndarray

    @classmethod
    def of(cls, limb: np.ndarray, station: np.ndarray, front: np.ndarray, side: np.ndarray) -> Cells:
        """Find the cells of samples from their limb, station [m], and the directions around it, shape [n] each."""
        sector = np.where(np.abs(front) >= np.abs(side), np.where(front >= 0, 0, 1), np.where(side >= 0, 2, 3))
        row = (limb.astype(np.int64) * SECTORS + sector) * STATIONS
        along = np.clip((station - START) / STATION, 0.0, STATIONS - 1e-3)
        before = np.clip(np.floor(along - 0.5), 0, STATIONS - 2).astype(np.int64)
        share = np.clip(along - 0.5 - before, 0.0, 1.0)
        return cls(row + np.floor(along).astype(np.int64), row + before, row + before + 1, share.astype(np.float32))


CELLS = len(Limb) * SECTORS * STATIONS
"""Number of cells."""


def cells_of(features: Features) -> Cells:
    """Find the cells of described samples."""
    place = features.place
    return Cells.of(place.limb, place.station, features.column("around_front"), features.column("around_side"))


def network_inputs(values: np.ndarray, rules: np.ndarray) -> np.ndarray:
    """Return what the network reads: features, shape [n, F], and logarithms of the rules' posterior, shape [n, 8]."""
    return np.hstack([values, np.log(np.maximum(rules, LEAST))]).astype(np.float32)


def sum_kinds(posterior: np.ndarray) -> np.ndarray:
    """Return the probability of each of `KINDS`, shape [n, 5], from that of each part, shape [n, 8]."""
    return np.stack([posterior[:, KIND == k].sum(axis=1) for k in range(len(KINDS))], axis=1)


def share_kinds(kinds: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the posterior of the parts, shape [n, 8], from that of `KINDS`, shape [n, 5].

    Args:
        kinds: Rows sum to 1.
        share: Which garment each sample is if it is one, by `share_garments`, shape [n, 8].
    """
    garment = np.isin(KIND, KIND[PARTS.index(Part.UPPER)])
    return np.asarray(kinds[:, KIND] * np.where(garment, share, 1.0))


def bound_logits(change: np.ndarray, bound: float) -> np.ndarray:
    """Return what is added to the rules' log-probabilities, shape [n, 5]: within -bound / 2 and bound / 2."""
    return np.asarray(0.5 * bound * np.tanh(change / (0.5 * bound))) if np.isfinite(bound) else change


@dataclass(frozen=True)
class Network:
    """Trained weights.

    Attributes:
        weights: Arrays by name: `mean` and `spread` of the features, matrices and biases of the layers.
        temperature: What the logits are divided by so that probabilities are true.
        bound: Of a network of kinds, the most by which it changes the log-odds of two kinds; None: it tells parts.
    """

    weights: dict[str, np.ndarray]
    temperature: float
    bound: float | None = None

    def predict(self, features: Features, rules: np.ndarray) -> np.ndarray:
        """Compute the posterior in the order of `PARTS`, rows sum to 1, float32, shape [n, 8].

        Args:
            features: The samples' description.
            rules: The posterior by rules, shape [n, 8]: the network corrects what it knows.
        """
        hidden = self.embed(network_inputs(features.values, rules), cells_of(features))
        return _soften(self._apply("part", hidden) / self.temperature)

    def predict_kinds(self, features: Features, rules: np.ndarray) -> np.ndarray:
        """Compute the posterior of `KINDS`, rows sum to 1, shape [n, 5]; arguments as of `predict`."""
        kinds = sum_kinds(rules)
        if self.bound is None:
            return sum_kinds(self.predict(features, rules))
        hidden = self.embed(network_inputs(features.values, kinds), cells_of(features))
        change = bound_logits(self._apply("part", hidden), self.bound)
        return _soften((np.log(kinds) + change) / self.temperature)

    def embed(self, values: np.ndarray, cells: Cells) -> np.ndarray:
        """Compute what the heads read, shape [n, width]."""
        w = self.weights
        hidden = np.clip((values - w["mean"]) / w["spread"], -REACH, REACH)
        hidden = _bend(self._apply("second", _bend(self._apply("first", hidden))))
        pooling = _Pooling.of(cells)
        for turn in range(ROUNDS):
            hidden = hidden + self._exchange(f"round{turn}", hidden, cells, pooling)
        return hidden

    def _exchange(self, name: str, hidden: np.ndarray, cells: Cells, pooling: _Pooling) -> np.ndarray:
        """Pool samples to cells, filter along limbs, join with the other side and the whole, and hand back."""
        width = hidden.shape[1]
        cell = _bend(self._apply(f"{name}.pool", pooling.pool(hidden)))
        cell = cell.reshape(len(Limb), SECTORS, STATIONS, width)
        slices = np.broadcast_to(cell.mean(axis=1, keepdims=True), cell.shape)
        other = slices[list(PARTNER)]
        cell = _bend(self._apply(f"{name}.mix", np.concatenate([cell, slices, other], axis=-1)))
        for i, dilation in enumerate(DILATIONS):
            cell = cell + _bend(self._filter(f"{name}.along{i}", cell, dilation))
        weight = pooling.full.reshape(len(Limb), SECTORS, STATIONS, 1)
        sums = [(cell[list(group)] * weight[list(group)]).sum(axis=(0, 1, 2)) for group in GROUPS]
        counts = [max(float(weight[list(group)].sum()), 1.0) for group in GROUPS]
        whole = np.concatenate([total / count for total, count in zip(sums, counts, strict=True)])
        whole = _bend(self._apply(f"{name}.whole1", _bend(self._apply(f"{name}.whole0", whole))))
        flat = cell.reshape(-1, width)
        near = flat[cells.low] * (1 - cells.share[:, None]) + flat[cells.high] * cells.share[:, None]
        joined = np.concatenate([hidden, near, np.broadcast_to(whole, hidden.shape)], axis=1)
        return self._apply(f"{name}.back1", _bend(self._apply(f"{name}.back0", joined)))

    def _apply(self, name: str, values: np.ndarray) -> np.ndarray:
        return np.asarray(values @ self.weights[f"{name}.weight"].T + self.weights[f"{name}.bias"])

    def _filter(self, name: str, cell: np.ndarray, dilation: int) -> np.ndarray:
        """Filter along the stations with five taps, nothing beyond the ends; weight of shape [out, in, 5]."""
        taps, bias = self.weights[f"{name}.weight"], self.weights[f"{name}.bias"]
        reach = dilation * (taps.shape[2] // 2)
        padded = np.pad(cell, ((0, 0), (0, 0), (reach, reach), (0, 0)))
        shifted = (padded[:, :, k * dilation : k * dilation + STATIONS] @ taps[:, :, k].T for k in range(taps.shape[2]))
        return np.asarray(sum(shifted) + bias)


@dataclass(frozen=True)
class _Pooling:
    """How samples are summed up in cells: their order by cell, where each cell begins, and which there are."""

    order: np.ndarray
    begin: np.ndarray
    cell: np.ndarray
    count: np.ndarray
    full: np.ndarray

    @classmethod
    def of(cls, cells: Cells) -> _Pooling:
        """Sort samples by cell."""
        order = np.argsort(cells.index, kind="stable")
        cell, begin, count = np.unique(cells.index[order], return_index=True, return_counts=True)
        full = np.zeros((CELLS, 1), np.float32)
        full[cell] = 1.0
        return cls(order, begin, cell, count, full)

    def pool(self, hidden: np.ndarray) -> np.ndarray:
        """Compute mean and maximum in each cell, 0 in empty ones, and which are not, shape [cells, 2 * width + 1]."""
        sorted_ = hidden[self.order]
        mean = np.zeros((CELLS, hidden.shape[1]), hidden.dtype)
        highest = np.zeros_like(mean)
        mean[self.cell] = np.add.reduceat(sorted_, self.begin) / self.count[:, None]
        highest[self.cell] = np.maximum.reduceat(sorted_, self.begin)
        return np.concatenate([mean, highest, self.full], axis=1)


def _soften(logits: np.ndarray) -> np.ndarray:
    chance = np.exp(logits - logits.max(axis=1, keepdims=True))
    return np.asarray(chance / chance.sum(axis=1, keepdims=True))


def _bend(values: np.ndarray) -> np.ndarray:
    return np.maximum(values, SLOPE * values)


def load_network(path: Path) -> Network | None:
    """Read a network; None where there is none, or where it was trained on another layout of features."""
    if not path.exists():
        return None
    with np.load(path) as kept:
        if int(kept["version"]) != VERSION:
            return None
        about = ("version", "temperature", "bound")
        weights = {name: kept[name].astype(np.float32) for name in kept.files if name not in about}
        bound = float(kept["bound"]) if "bound" in kept.files else None
        return Network(weights, float(kept["temperature"]), bound)
