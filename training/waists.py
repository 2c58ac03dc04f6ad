"""Measure what the ring between upper and lower says of one piece and of two: `python -m garmentq.training.waists`.

Each described scan is asked with colours, drawn for every one, and without. The constants of `core/people/rules.py` are
rounded from those that make what is worn on the given persons most probable.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from ..core.people.evidence import find_rings
from ..core.people.features import describe_points
from ..core.people.part import Part
from ..core.people.points import sample_person
from ..core.people.rules import WaistModel, WaistShown, waist_evidence
from .colours import paint
from .describe import load_described, unpack_fit
from .shards import load_shard

PRESENT = 0.02
"""Share of the samples from which on a garment is worn: a forgotten hem of 1 % shows nothing."""

FIRM = 4.0
"""Scans that the constants of today weigh as much as, so that a small set does not carry them off."""


@dataclass(frozen=True)
class WaistRow:
    """What the best ring of one scan says.

    Attributes:
        scan: Name of the scan.
        is_one_piece: Whether one piece is worn and not two, in truth.
        is_layered: Whether an outer layer is, in truth: its hem shows instead.
        shape: Score of the best ring between upper and lower without colours.
        coloured: The same with colours.
        between: Score by shape of that ring.
        tube: Share of the height below the crotch in which cloth spans from leg to leg.
        roughness: Noise of ridges around the trunk.
    """

    scan: str
    is_one_piece: bool
    is_layered: bool
    shape: float
    coloured: float
    between: float
    tube: float
    roughness: float = 0.0


def find_rows(persons: Path, samples: Path) -> list[WaistRow]:
    """Return the rows of all described scans of a folder on which one piece or two are worn."""
    rows = []
    for path in sorted(samples.glob("*.npz")):
        shard, described = load_shard(persons / path.name), load_described(path)
        worn = {part: (described.label == part).mean() > PRESENT for part in Part}
        if worn[Part.ONE_PIECE] == (worn[Part.UPPER] and worn[Part.LOWER]):
            continue
        fit = unpack_fit(described.state)
        points = sample_person(replace(shard.raw_scan(), colours=paint(shard, always=True)), fit)
        features = describe_points(points, fit)
        rings = find_rings(points, features, fit)
        best = rings.waists[0]
        shown = rings.waists_by_shape[0].score, best.score, best.by_shape, rings.tube, rings.roughness
        rows.append(WaistRow(path.stem, bool(worn[Part.ONE_PIECE]), bool(worn[Part.OUTER]), *shown))
    return rows


def fit_model(rows: Iterable[WaistRow]) -> WaistModel:
    """Return the constants that make rows without an outer layer most probable, both kinds weighed alike.

    The constants have a normal prior around those of today, the share a beta one, which count as `FIRM` scans: without
    it, no waist that is hidden would be taken for none that can be.
    """
    own = [row for row in rows if not row.is_layered]
    one = np.array([row.is_one_piece for row in own])
    weight = np.where(one, len(own) / max(2 * one.sum(), 1), len(own) / max(2 * (~one).sum(), 1))
    start = WaistModel()

    def surprise(u: np.ndarray) -> float:
        model = _unpack(u)
        loss = 0.0
        for row, is_one, w in zip(own, one, weight, strict=True):
            for coloured in (None, row.coloured):
                shown = WaistShown(row.shape, coloured, roughness=row.roughness, between=row.between)
                odds = waist_evidence(shown, model)
                loss += w * float(np.logaddexp(0.0, odds if is_one else -odds))
        drift = 0.0
        for now, before in ((model.by_shape, start.by_shape), (model.with_colours, start.with_colours)):
            drift += ((now[0] - before[0]) / before[1]) ** 2 + np.log(now[1] / before[1]) ** 2
        share = start.hidden * np.log(model.hidden) + (1 - start.hidden) * np.log(1 - model.hidden)
        return loss + FIRM * (0.5 * drift - share)

    found = minimize(surprise, _pack(start), method="Nelder-Mead", options={"maxiter": 4000, "xatol": 1e-3})
    return _unpack(found.x)


def _pack(model: WaistModel) -> np.ndarray:
    (a, b), (c, d), h = model.by_shape, model.with_colours, model.hidden
    return np.array([a, np.log(b), c, np.log(d), np.log(h / (1 - h))])


def _unpack(u: np.ndarray) -> WaistModel:
    scale = np.exp(np.clip(u[[1, 3]], -1.0, 4.0))
    return WaistModel((float(u[0]), float(scale[0])), (float(u[2]), float(scale[1])), float(1 / (1 + np.exp(-u[4]))))


def summarise(rows: list[WaistRow]) -> dict[str, dict[str, float]]:
    """Return count and quantiles of the scores of one piece and of two; no outer layers."""
    found = {}
    for name in ("shape", "coloured", "between"):
        for is_one in (True, False):
            own = [getattr(row, name) for row in rows if row.is_one_piece == is_one and not row.is_layered]
            if own:
                quantiles = np.quantile(own, (0.0, 0.1, 0.5, 0.9, 1.0))
                words = ("least", "tenth", "median", "ninth_tenth", "most")
                key = f"{name}, {'one piece' if is_one else 'two'}"
                found[key] = {"count": float(len(own))} | dict(zip(words, map(float, quantiles), strict=True))
    return found


def main() -> None:
    """Print the rows, their summary and the constants as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--persons", type=Path, required=True, help="folder of scans")
    parser.add_argument("--samples", type=Path, required=True, help="folder of their described samples")
    options = parser.parse_args()
    rows = find_rows(options.persons, options.samples)
    figures = {"rows": [asdict(row) for row in rows], "summary": summarise(rows), "model": asdict(fit_model(rows))}
    print(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
