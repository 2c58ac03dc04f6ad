"""Measure by how much a body fitted below cloth is too thick: `python -m garmentq.training.depth --samples DIR`.

The figures of `core/people/depth.py` are rounded from what it prints.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..core.people.depth import ARM, HANGING, HELD, LEG, OVER, Excess, find_looseness
from ..core.people.features import FEATURE_LENGTH_SCALE, FEATURE_NAMES
from ..core.people.limbs import Limb
from ..core.people.part import GARMENTS, Part
from .describe import Described
from .train import load_set

ASKED: dict[str, tuple[Excess, tuple[Limb, ...], tuple[Part, ...]]] = {
    "hanging": (HANGING, (Limb.TRUNK,), (Part.UPPER, Part.ONE_PIECE)),
    "over": (OVER, (Limb.TRUNK,), (Part.OUTER,)),
    "held": (HELD, (Limb.TRUNK,), (Part.LOWER,)),
    "arm": (ARM, (Limb.LEFT_ARM, Limb.RIGHT_ARM), GARMENTS),
    "leg": (LEG, (Limb.LEFT_LEG, Limb.RIGHT_LEG), GARMENTS),
}
"""The excess of today, whose stations are kept, and the limbs and the garments that each is of."""

FEWEST = 20
"""Samples of a scan around a station that make a figure."""


@dataclass(frozen=True)
class Measured:
    """What scans show at the stations of one excess.

    Attributes:
        mean: By how much the fit is too thick [m], shape [station_count].
        spread: Standard deviation about it [m], shape [station_count].
        scans: Limbs of scans that have a figure there, shape [station_count].
    """

    mean: np.ndarray
    spread: np.ndarray
    scans: np.ndarray


def measure_excess(
    scans: list[Described], excess: Excess, limbs: tuple[Limb, ...], parts: tuple[Part, ...] = GARMENTS
) -> Measured:
    """Fit e and s of d = h + l e + l s z, z of unit variance, at each station, every limb of a scan weighing alike.

    Notation: d `tightness`, h the height over the fit, l the looseness of the garment there, e `mean`, s `spread`.
    """
    stations = np.array(excess.stations)
    sums = np.zeros((4, len(stations)))
    for scan in scans:
        height = FEATURE_LENGTH_SCALE * scan.values[:, FEATURE_NAMES.index("offset")]
        for limb in limbs:
            for part in parts:
                mine = (scan.limb == limb) & (scan.label == part)
                if mine.sum() < FEWEST:
                    continue
                loose = find_looseness(height[mine], scan.station[mine], limb)
                nearest = np.abs(scan.station[mine, None] - stations).argmin(axis=1)
                hidden = (scan.tightness - height)[mine]
                count = np.bincount(nearest, minlength=len(stations))
                enough = count >= FEWEST
                share = enough / np.maximum(count, 1)
                sums[0] += enough * loose**2
                sums[1] += share * loose * np.bincount(nearest, hidden, len(stations))
                sums[2] += share * loose**2 * np.bincount(nearest, hidden**2, len(stations))
                sums[3] += enough
    weight, first, second, count = sums
    mean = first / np.maximum(weight, 1e-9)
    return Measured(mean, np.sqrt(np.maximum(second / np.maximum(weight, 1e-9) - mean**2, 0.0)), count)


def main() -> None:
    """Print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--samples", type=Path, nargs="+", required=True, help="folders of described scans")
    options = parser.parse_args()
    scans = [scan for folder in options.samples for scan in load_set(folder)]
    found = {}
    for name, (excess, limbs, parts) in ASKED.items():
        measured = measure_excess(scans, excess, limbs, parts)
        found[name] = {"stations": excess.stations} | {
            key: [round(float(value), 4) for value in getattr(measured, key)] for key in ("mean", "spread", "scans")
        }
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
