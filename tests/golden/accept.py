"""Accept what the golden scenes measure now: `python tests/golden/accept.py --reason "..." [--scene NAME]`.

Each scene runs as it is, then with its input moved by 1e-12 m and by 0.1 mm, which says how far each number may be off
from now on. Old values, new ones and the reason go into `golden.json`.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor

from golden_numbers import Measured
from golden_record import accept, compare, describe_scatter, load_record, save_record
from golden_scenes import SCENES, Shift

SHIFTS = (Shift(), Shift(1e-12, 1), Shift(1e-12, 2), Shift(1e-4, 3), Shift(1e-4, 4))
"""What a scene's scatter is taken from: rounding, which may send cloth into other folds, and a good scanner's noise."""


def run(name: str, shift: Shift) -> Measured:
    """Run one scene."""
    return SCENES[name](shift)


def main() -> None:
    """Run the scenes that are asked for and write the record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--reason", required=True, help="why the numbers are other ones now; kept beside them")
    parser.add_argument("--scene", action="append", choices=sorted(SCENES), help="only this one; may be repeated")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    if not given.reason.strip():
        parser.error("say why: REASON='...'")
    names = given.scene or sorted(SCENES)
    record = load_record()
    with ProcessPoolExecutor(given.processes) as pool:
        runs = {name: [pool.submit(run, name, shift) for shift in SHIFTS] for name in names}
        for name, futures in runs.items():
            found = [future.result() for future in futures]
            old = record["scenes"].get(name)
            if old is not None and not compare(name, old, found[0]):
                sys.stdout.write(f"{name}: as accepted\n")
                continue
            for line in accept(record, name, describe_scatter(found), given.reason):
                sys.stdout.write(line + "\n")
            save_record(record)


if __name__ == "__main__":
    main()
