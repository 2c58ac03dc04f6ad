"""Measure GarmentCode's bodies, and print how far off its own tables are: `python benchmarks/body_tables.py CHECKOUT`.

CHECKOUT is a checkout of GarmentCode; its `assets/bodies` has meshes with tables of their measures. They are for
measuring only and are not part of this package.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from garmentq.core.body.body_tape import measure_body
from garmentq.core.body.dress_form import register_wearer
from garmentq.core.body.measure_names import HOW_MEASURED, MEASURE_KINDS, Quantity
from garmentq.core.body.measure_table import read_measure_table
from garmentq.core.body.measures_file import read_table_text
from garmentq.core.scan.load import load_scan

NAMES = ("mean_all", "mean_female", "mean_male", "mean_all_tpose")


def compare(folder: Path, name: str) -> dict[str, tuple[float, float]]:
    """Return each measure of a body and its difference to the table [mm or degrees]."""
    scan = load_scan(folder / f"{name}.obj", units=None, up=None, kind="body")
    figure = measure_body(register_wearer(scan.vertices, scan.faces, name=name))
    table = read_measure_table(read_table_text(folder / f"{name}.yaml")).rows[0].measures
    found = {}
    for one in figure.measures:
        scale = np.degrees(1.0) if MEASURE_KINDS[one.name].quantity == Quantity.ANGLE else 1e3
        found[one.name] = (scale * one.value, scale * (one.value - table[one.name]))
    return found


def main() -> None:
    """Print a table of all measures of all bodies."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkout", type=Path)
    folder = parser.parse_args().checkout / "assets" / "bodies"
    found = {name: compare(folder, name) for name in NAMES}
    print("| measure [mm or degrees] | " + " | ".join(NAMES) + " |\n" + "|---" * (len(NAMES) + 1) + "|")
    for name in HOW_MEASURED:
        cells = [f"{found[body][name][0]:.1f} ({found[body][name][1]:+.1f})" for body in NAMES]
        print(f"| {name} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
