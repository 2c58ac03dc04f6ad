"""Fit the body to simulated scans and describe their samples: what the trainers read.

Run as `python -m garmentq.training.describe --persons DIR --out DIR`. The body is fitted to the noisy scan as it is to
any scan, never taken from the simulation: a trainer must see the offsets that a separation will see. Of every other
scan it is fitted once more with the labels, a share of them wrong, as a separation's second round is.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ..core.body.fit import State
from ..core.body.person import PersonFit, PointWeights, fit_person, refit_person
from ..core.body.registration import body_of_state
from ..core.body.template import load_template
from ..core.errors import GarmentqError
from ..core.person import CLOTH, Part
from ..core.person.features import VERSION, describe_points
from ..core.person.points import PersonPoints, sample_person
from ..core.person.rules import predict_by_rules
from .runtime import network_inputs
from .shards import Shard, load_shard

WRONG = (0.02, 0.2)
"""Range of the share of patches whose label is wrong when the body is fitted for the second round."""
PATCH = 0.05
"""Width [m] of a patch whose label is wrong."""


@dataclass(frozen=True)
class Described:
    """The samples of one scan, described.

    Attributes:
        values: Features, float32, shape [n, F].
        positions: Positions [m], shape [n, 3].
        normals: Unit normals, shape [n, 3].
        limb: The `Limb` of each sample, shape [n].
        station: Length along it [m], shape [n].
        rules: The rules' posterior in the order of `PARTS`, shape [n, 8].
        label: `Part` numbers, shape [n].
        tightness: Distance to the true body [m], shape [n].
        border: Distance to another label [m], shape [n].
        state: The fit: shape coefficients, rotations [24 * 9] and translation [3], one after the other.
        about: The scan's, with `body_error`, the mean distance of the true body to the fitted one [m].
    """

    values: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    limb: np.ndarray
    station: np.ndarray
    rules: np.ndarray
    label: np.ndarray
    tightness: np.ndarray
    border: np.ndarray
    state: np.ndarray
    about: dict

    @cached_property
    def inputs(self) -> np.ndarray:
        """Return what the learners read, shape [n, F + 8]."""
        return network_inputs(self.values, self.rules)


def describe(shard: Shard, rounds: int) -> Described:
    """Fit the body to a scan and describe its samples.

    Args:
        shard: The scan.
        rounds: 1 for the fit that knows nothing, 2 for one more with labels of which some are wrong.
    """
    raw = shard.raw_scan()
    fit = fit_person(raw.points, raw.normals, True)
    points = sample_person(raw, fit)
    near = nearest_points(points, shard)
    if rounds > 1:
        fit = _refit(fit, points, shard.label[near], int(shard.about["seed"]))
    features = describe_points(points, fit)
    error = cKDTree(fit.body.vertices).query(shard.body_vertices)[0]
    about = shard.about | {"rounds": rounds, "version": VERSION, "body_error": float(error.mean())}
    return Described(
        features.values,
        points.positions,
        points.normals,
        features.place.limb,
        features.place.station,
        predict_by_rules(points, features, fit),
        shard.label[near],
        shard.tightness[near],
        shard.border[near],
        pack_state(fit.state),
        about,
    )


def pack_state(state: State) -> np.ndarray:
    """Return a fit as one row of numbers."""
    return np.concatenate([state.shape, state.rotations.ravel(), state.translation])


def unpack_fit(packed: np.ndarray) -> PersonFit:
    """Return the fit of a row of numbers, without its figures."""
    packed = packed.astype(np.float64)
    state = State(packed[:-219], packed[-219:-3].reshape(24, 3, 3), packed[-3:])
    return PersonFit(body_of_state(load_template(), state, 0.0), state, 0.0, 0.0, 0.0, 0.0)


def nearest_points(points: PersonPoints, shard: Shard) -> np.ndarray:
    """Return the scan's point nearest to each sample, one that faces alike before one that does not, shape [n]."""
    length = 0.01
    tree = cKDTree(np.hstack([shard.points, length * shard.normals]))
    return np.asarray(tree.query(np.hstack([points.positions, length * points.normals]))[1])


def _refit(fit: PersonFit, points: PersonPoints, label: np.ndarray, seed: int) -> PersonFit:
    """Fit again with labels of which a share of patches is another sample's."""
    rng = np.random.default_rng(seed)
    cell = np.unique(np.floor(points.positions / PATCH).astype(int), axis=0, return_inverse=True)[1].ravel()
    wrong = rng.random(cell.max() + 1) < rng.uniform(*WRONG)
    label = np.where(wrong[cell], rng.choice(label, cell.max() + 1)[cell], label)
    cloth = np.isin(label, [int(part) for part in CLOTH]).astype(float)
    ignored = np.isin(label, [int(part) for part in (Part.HAIR, Part.SHOES, Part.OTHER)]).astype(float)
    return refit_person(fit, points.positions, points.normals, PointWeights(cloth, ignored))


def save_described(described: Described, path: Path) -> None:
    """Write the samples of a scan."""
    started = path.with_suffix(".part")
    arrays = {k: v for k, v in described.__dict__.items() if k not in ("about", "inputs")}
    with started.open("wb") as file:
        np.savez(
            file,
            about=json.dumps(described.about),
            **{k: v.astype(np.float32) if v.dtype == np.float64 and k != "state" else v for k, v in arrays.items()},
        )
    started.replace(path)


def load_described(path: Path) -> Described:
    """Read the samples of a scan."""
    with np.load(path) as kept:
        arrays = {name: kept[name] for name in kept.files if name != "about"}
        return Described(**arrays, about=json.loads(str(kept["about"])))


def describe_folder(persons: Path, out: Path, limit: float | None = None) -> int:
    """Describe the scans of a folder that are not described yet, and return their number.

    Args:
        persons: Scans, as `persons.py` writes them.
        out: The folder for the samples.
        limit: Stop after so many seconds.
    """
    out.mkdir(parents=True, exist_ok=True)
    start, count = time.monotonic(), 0
    for path in sorted(persons.glob("*.npz")):
        if limit is not None and time.monotonic() - start > limit:
            break
        if (out / path.name).exists() or (out / path.with_suffix(".none").name).exists():
            continue
        cpu = time.process_time()
        shard = load_shard(path)
        try:
            described = describe(shard, 1 + (shard.about["seed"] + shard.about["scan"]) % 2)
        except GarmentqError as problem:
            (out / path.with_suffix(".none").name).write_text(str(problem))
            print(f"{path.stem} {problem}", flush=True)
            continue
        save_described(described, out / path.name)
        count += 1
        used, error = time.process_time() - cpu, 1e3 * described.about["body_error"]
        print(f"{path.stem} {used:.1f} s, {len(described.label)} samples, body {error:.1f} mm", flush=True)
    return count


def main() -> None:
    """Describe a folder."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--persons", type=Path, required=True, help="folder of scans")
    parser.add_argument("--out", type=Path, required=True, help="folder for the samples")
    parser.add_argument("--limit", type=float, help="stop after so many seconds")
    options = parser.parse_args()
    describe_folder(options.persons, options.out, options.limit)


if __name__ == "__main__":
    main()
