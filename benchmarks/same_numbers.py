"""Compare to the last bit what the golden scenes measure at a commit and now: for changes that move code alone.

    python benchmarks/same_numbers.py COMMIT [--scene NAME] [--processes 2]

Each tree runs its own scenes, both on this machine and in one sitting: libraries differ by processor. Ends with status
1 where a number or a word is another one.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from bench_runs import Version, find_version
from changed_tree import ROOT, make_environment

RUN = """
import json, sys
sys.path.insert(0, sys.argv[1])
from golden_scenes import SCENES, Shift
found = SCENES[sys.argv[2]](Shift())
print(json.dumps({**found.numbers, **found.words}))
"""
"""Prints what a scene measures; a number's text tells all of its bits."""


def measure(version: Version, scene: str) -> dict[str, Any]:
    """Return what a scene of a version's own measures."""
    line = [sys.executable, "-c", RUN, str(version.root / "tests" / "golden"), scene]
    ran = subprocess.run(line, env=make_environment(version.root), check=True, capture_output=True, text=True)
    found: dict[str, Any] = json.loads(ran.stdout.splitlines()[-1])
    return found


def list_differences(before: dict[str, Any], now: dict[str, Any]) -> Iterable[str]:
    """Return a line for each name whose value is another one, or that only one of both has."""
    for name in sorted({*before, *now}):
        if name not in before or name not in now:
            yield f"{name}: only {'now' if name in now else 'before'}"
        elif before[name] != now[name]:
            yield f"{name}: {before[name]} -> {now[name]}"


def main() -> None:
    """Run the scenes and print what differs."""
    known = sorted(json.loads((ROOT / "tests" / "golden" / "golden.json").read_text())["scenes"])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit", help="what this tree is compared with")
    parser.add_argument("--scene", action="append", choices=known, help="only this one; may be repeated")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "same", help="where the commit is checked out")
    given = parser.parse_args()
    before, now = find_version(given.commit, given.out.resolve()), Version("now", ROOT)
    scenes = given.scene or known
    with ThreadPoolExecutor(given.processes) as pool:
        runs = {(v.name, s): pool.submit(measure, v, s) for s in scenes for v in (before, now)}
        differ = 0
        for scene in scenes:
            old, new = (runs[v.name, scene].result() for v in (before, now))
            lines = list(list_differences(old, new))
            differ += len(lines)
            print(f"{scene}: {len(new)} values, {len(lines)} differ", *lines, sep="\n  ", flush=True)
    sys.exit(differ > 0)


if __name__ == "__main__":
    main()
