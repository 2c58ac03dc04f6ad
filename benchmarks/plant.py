"""Draw errors of a list, plant each in a copy of the checkout, and tell which the golden scenes notice.

    python benchmarks/plant.py --seed 7 [--count 12] [--minutes 90] [--suite] [--without tests/test_x.py]

With `--suite` the rest of the suite runs instead of the golden scenes, up to its first failure; the tests that import
the changed module come first. First of all runs the copy without any error: where that fails, nothing that follows
would say anything, and the run ends. What was run lies in `out/plant/SEED` (`out/plant/SEED-suite`) and is not run
again; remove the folder where the checkout has changed.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from changed_tree import ROOT, ChangedTree, Outcome, try_all
from mutate import list_tests
from planted_errors import ERRORS, PlantedError

GATE = ("tests/golden", "-m", "nightly or not nightly", "-k", "measures_what_was_accepted")
SUITE = ("tests", "--ignore", "tests/golden")
"""What pytest runs: all golden scenes; all but these, and the test of the list, which any error fails."""

GATE_SECONDS, SUITE_SECONDS = 1800.0, 14_400.0
"""Limits of one run, of CPU."""

UNCHANGED = "unchanged"
"""Name of the run without an error."""


@dataclass(frozen=True)
class Check:
    """Describe what runs on a changed tree.

    Attributes:
        tests: The folder of the tests, then options of pytest.
        seconds: It is stopped after these.
        nearest_first: Whether the tests that import the changed module run before all.
    """

    tests: Sequence[str]
    seconds: float
    nearest_first: bool = False

    def run(self, tree: ChangedTree, path: str) -> Outcome:
        """Return what pytest told of a tree in which the module at a path is changed."""
        nearest = list_tests(tree.root, path) if self.nearest_first else []
        if nearest and (ran := tree.test([*nearest, *self.tests[1:]], self.seconds)).is_caught:
            return ran
        return tree.test(self.tests, self.seconds)


@dataclass(frozen=True)
class Trial:
    """Describe an error that was planted, and what noticed.

    Attributes:
        is_caught: Whether a test failed.
        is_cut_short: Whether the run was stopped before its end.
        told: The line of the first failure, or the last line.
        seconds: Wall time.
    """

    is_caught: bool
    is_cut_short: bool
    told: str
    seconds: float

    @property
    def cells(self) -> tuple[str, str]:
        """Return what caught it, a scene or a test, and the number or the message; of what was missed no number."""
        if not self.is_caught:
            return "not finished" if self.is_cut_short else "not caught", ""
        if not self.told.startswith(("FAILED", "ERROR")):
            return "pytest", self.told  # which could not even begin
        test, _, message = self.told.partition(" - ")
        scene = re.search(r"test_golden\.py::\w+\[(\w+)\]", test)
        place = scene[1] if scene else test.rpartition(" ")[2]
        return place, message.removeprefix("AssertionError: ").removeprefix(f"{place}: ").replace("|", "\\|")


def draw_errors(seed: int, count: int) -> list[PlantedError]:
    """Return as many errors of the list, in the order in which the seed draws them."""
    return [ERRORS[n] for n in np.random.default_rng(seed).choice(len(ERRORS), count, replace=False)]


def run(errors: Sequence[PlantedError], folder: Path, check: Check, minutes: float, processes: int) -> dict[str, Trial]:
    """Return the trials of errors, by their names; those that were run before from their files in a folder.

    Raises:
        SystemExit: where the check fails without an error.
    """
    asked = {re.sub(r"\W+", "_", error.name): error for error in errors}

    def attempt(tree: ChangedTree, name: str) -> dict[str, Any]:
        begun = time.monotonic()
        if name == UNCHANGED:
            ran = tree.test(check.tests, check.seconds)
        else:
            error = asked[name]
            with tree.changed(error.path, error.plant((tree.root / error.path).read_text()), error.words):
                ran = check.run(tree, error.path)
        trial = Trial(ran.is_caught, ran.is_cut_short, ran.told, time.monotonic() - begun)
        print(f"{name}: {' '.join(trial.cells)} ({trial.seconds:.0f} s)", file=sys.stderr, flush=True)
        return asdict(trial)

    control = Trial(**try_all(folder, [UNCHANGED], attempt, minutes, 1)[UNCHANGED])
    if control.is_caught or control.is_cut_short:
        raise SystemExit(f"fails without an error: {control.told}; mend it, and remove {folder / UNCHANGED}.json.")
    found = try_all(folder, list(asked), attempt, minutes, processes)
    return {asked[name].name: Trial(**told) for name, told in found.items()}


def main() -> None:
    """Print each error with what noticed it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=12, help="errors")
    parser.add_argument("--minutes", type=float, default=90.0, help="no error is planted later")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--suite", action="store_true", help="run the rest of the suite, not the golden scenes")
    parser.add_argument("--without", action="append", default=[], help="a test to leave out; may be repeated")
    given = parser.parse_args()
    if not 1 <= given.count <= len(ERRORS):
        parser.error(f"there are {len(ERRORS)} errors; draw 1 to {len(ERRORS)}.")
    check = Check(SUITE, SUITE_SECONDS, nearest_first=True) if given.suite else Check(GATE, GATE_SECONDS)
    left_out = [f"--deselect={test}" for test in given.without]
    folder = ROOT / "out" / "plant" / f"{given.seed}{'-suite' if given.suite else ''}"
    errors = draw_errors(given.seed, given.count)
    check = replace(check, tests=(*check.tests, *left_out))
    trials = run(errors, folder, check, given.minutes, given.processes)
    caught = sum(trial.is_caught for trial in trials.values())
    print(f"{caught} of {len(trials)} caught, {len(errors)} drawn:\n\n| error | kind | caught by | number | s |")
    print("|---|---|---|---|---|")
    for error in errors:
        if error.name in trials:
            trial = trials[error.name]
            print(f"| {error.name} | {error.kind} | {' | '.join(trial.cells)} | {trial.seconds:.0f} |")


if __name__ == "__main__":
    main()
