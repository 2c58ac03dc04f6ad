"""Fit the body to simulated scans and describe their samples: what the trainers read.

Run as `python -m garmentq.training.describe --persons DIR --out DIR`. The body is fitted to the noisy scan as a
separation fits it, below what the rules take for cloth, never taken from the simulation: a trainer must see the offsets
that a separation will see, with the errors that wrong labels make.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ..core.body.fit import FitState
from ..core.body.person import PersonFit, fit_person
from ..core.body.registration import body_of_state
from ..core.body.template import load_template, rotations_of
from ..core.people.diffusion import link_points
from ..core.people.features import FEATURE_LAYOUT_VERSION, describe_points
from ..core.people.networks import network_inputs, parts_to_kinds
from ..core.people.points import PersonPoints, sample_person
from ..core.people.rules import tell_by_rules
from ..core.people.separate import fit_below_clothes
from ..core.people.tone import skin_evidence
from ..core.run.errors import GarmentqError
from ..core.scan.raw import RawScan
from .colours import paint
from .shards import Shard, load_shard, nearest_points


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
        share: Which garment each sample is by the rules if it is one, shape [n, 8].
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
    share: np.ndarray
    label: np.ndarray
    tightness: np.ndarray
    border: np.ndarray
    state: np.ndarray
    about: dict

    @cached_property
    def inputs(self) -> np.ndarray:
        """Return what the learners read, shape [n, F + 8]."""
        return network_inputs(self.values, self.rules)

    @cached_property
    def kind_inputs(self) -> np.ndarray:
        """Return what a network of kinds reads, shape [n, F + 5]."""
        return network_inputs(self.values, parts_to_kinds(self.rules))


def describe(shard: Shard) -> Described:
    """Fit the body to a scan as a separation does, and describe its samples."""
    raw = painted_scan(shard)
    fit = fit_person(raw.points, raw.normals, True)
    points = sample_person(raw, fit)
    fit = fit_below_clothes(fit, points, link_points(points.positions, points.normals))
    return describe_fitted(shard, points, fit)


def describe_given(shard: Shard) -> Described:
    """Describe the samples of a scan around the true body, as where the user gives it.

    Raises:
        NoModel: where the wearer is a child, of whom the built-in body is no model.
    """
    if shard.about["gender"] == "child":
        raise NoModel
    fit = true_fit(shard)
    return describe_fitted(shard, sample_person(painted_scan(shard), fit), fit)


class NoModel(GarmentqError):
    """The built-in body does not model this wearer; describe the scan around a fitted body."""

    code = "training.no_model"


def true_fit(shard: Shard) -> PersonFit:
    """Return the true body as a fit would be."""
    own = shard.parameters
    return unpack_fit(pack_state(FitState(own["shape"], rotations_of(own["pose"]), own["translation"])))


def describe_fitted(shard: Shard, points: PersonPoints, fit: PersonFit) -> Described:
    """Describe the samples of a scan to which the body was fitted."""
    near = nearest_points(points, shard)
    features = describe_points(points, fit)
    tone = None if points.lab is None else skin_evidence(points.lab, features.place, fit.body)
    rules = tell_by_rules(points, features, fit, tone)
    error = cKDTree(fit.body.vertices).query(shard.body_vertices)[0]
    about = shard.about | {"version": FEATURE_LAYOUT_VERSION, "coloured": points.colours is not None}
    return Described(
        features.values,
        points.positions,
        points.normals,
        features.place.limb,
        features.place.station,
        rules.posterior,
        rules.share,
        shard.label[near],
        shard.tightness[near],
        shard.border[near],
        pack_state(fit.state),
        about | {"body_error": float(error.mean())},
    )


def painted_scan(shard: Shard) -> RawScan:
    """Return a scan with the colours that its scanner gave."""
    return replace(shard.raw_scan(), colours=paint(shard))


def pack_state(state: FitState) -> np.ndarray:
    """Return a fit as one row of numbers."""
    return np.concatenate([state.shape, state.rotations.ravel(), state.translation])


def unpack_fit(packed: np.ndarray) -> PersonFit:
    """Return the fit of a row of numbers, without its figures."""
    packed = packed.astype(np.float64)
    state = FitState(packed[:-219], packed[-219:-3].reshape(24, 3, 3), packed[-3:])
    return PersonFit(body_of_state(load_template(), state, 0.0), state, 0.0, 0.0, 0.0, 0.0)


def save_described(described: Described, path: Path) -> None:
    """Write the samples of a scan."""
    started = path.with_suffix(".part")
    arrays = {k: v for k, v in described.__dict__.items() if k not in ("about", "inputs", "kind_inputs")}
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


Describe = Callable[[Shard], Described]
"""From a scan to its described samples."""


def describe_folder(persons: Path, out: Path, limit: float | None = None, how: Describe = describe) -> int:
    """Describe the scans of a folder that are not described yet, and return their number.

    Args:
        persons: Scans, as `persons.py` writes them.
        out: The folder for the samples.
        limit: Stop after so many seconds.
        how: How a scan is described.
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
            described = how(shard)
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
    parser.add_argument("--given", action="store_true", help="around the true body, and not around one that is fitted")
    parser.add_argument("--limit", type=float, help="stop after so many seconds")
    options = parser.parse_args()
    describe_folder(options.persons, options.out, options.limit, describe_given if options.given else describe)


if __name__ == "__main__":
    main()
