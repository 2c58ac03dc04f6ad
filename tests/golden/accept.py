"""Accept what the golden scenes measure now: `python tests/golden/accept.py --reason "..." [--scene NAME]`.

Each scene runs as it is, with its input moved by 1e-12 m and by 0.1 mm, and with the instructions of other processors:
that says how far each number may be off from now on. Old values, new ones and the reason go into `golden.json`.
With `--machine` the values stay, and numbers of this machine that are farther off than any of these runs widen what is
allowed.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from unittest.mock import patch

from golden_numbers import Measured
from golden_record import accept, compare, describe_scatter, load_record, save_record, widen
from golden_scenes import SCENES, Shift

SHIFTS = (Shift(), Shift(1e-12, 1), Shift(1e-12, 2), Shift(1e-4, 3), Shift(1e-4, 4))
"""What a scene's scatter is taken from: rounding, which may send cloth into other folds, and a good scanner's noise."""


PROCESSORS: tuple[Mapping[str, str], ...] = (
    {"OPENBLAS_CORETYPE": "Nehalem", "NUMBA_CPU_NAME": "generic"},
    {"OPENBLAS_CORETYPE": "Haswell", "NUMBA_CPU_NAME": "haswell"},
)
"""Variables by which sums are formed as on a processor of 2008 (vectors of two) and of 2013 (of four, fused)."""


def run(name: str, shift: Shift) -> Measured:
    """Run one scene."""
    return SCENES[name](shift)


def run_all(names: Sequence[str], processes: int) -> dict[str, list[Measured]]:
    """Return what each scene measures in all runs, that of the scene as it is first."""
    found: dict[str, list[Measured]] = {name: [] for name in names}
    for variables, shifts in (({}, SHIFTS), *((each, SHIFTS[:1]) for each in PROCESSORS)):
        afresh = multiprocessing.get_context("spawn")  # libraries read the variables once
        with patch.dict(os.environ, variables), ProcessPoolExecutor(processes, afresh) as pool:
            futures = {name: [pool.submit(run, name, shift) for shift in shifts] for name in names}
            for name, own in futures.items():
                found[name] += [future.result() for future in own]
    return found


def main() -> None:
    """Run the scenes that are asked for and write the record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--reason", required=True, help="why the numbers are other ones now; kept beside them")
    parser.add_argument(
        "--scene", action="append", choices=sorted(SCENES), help="only this one, even as accepted; may be repeated"
    )
    parser.add_argument("--machine", action="store_true", help="allow what this machine measures; values stay")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    if not given.reason.strip():
        parser.error("say why: REASON='...'")
    record = load_record()
    if given.machine:
        for name in given.scene or sorted(SCENES):
            for line in widen(record, name, run(name, Shift()), given.reason):
                sys.stdout.write(line + "\n")
            save_record(record)
        return
    for name, found in run_all(given.scene or sorted(SCENES), given.processes).items():
        old = record["scenes"].get(name)
        if not given.scene and old is not None and not compare(name, old, found[0]):
            sys.stdout.write(f"{name}: as accepted\n")
            continue
        for line in accept(record, name, describe_scatter(found), given.reason):
            sys.stdout.write(line + "\n")
        save_record(record)


if __name__ == "__main__":
    main()
