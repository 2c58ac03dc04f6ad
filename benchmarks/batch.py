"""How a batch of garments scales with the jobs at a time, through the service, and whether its results stay the same.

    python benchmarks/batch.py PACK... [--copies 2] [--workers 1 --workers 2] [--quality preview] [--redrape later]

Each pack is a folder with `garment.ply`, `body.ply` and perhaps `template.json`. All are submitted to a home of their
own for each number of workers; the clock runs from the workers' start to the end of the last job, re-drapes counted.
Kernels are compiled before. Ends with status 1 where a mesh, a pattern or a metric is another one.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from changed_tree import ROOT, make_environment
from garmentq.service.database import Database
from garmentq.service.query import count_states
from garmentq.service.settings import read_settings
from garmentq.service.states import State

SAME_FILES = ("detail.ply", "simulation.ply", "graded.ply", "redrape.ply", "pattern.json", "metrics.json")
"""Files of a result that the clock and the jobs' names do not enter."""


@dataclass(frozen=True)
class Batch:
    """Describe what is submitted.

    Attributes:
        packs: Folders.
        copies: Number of jobs of each.
        options: Of `garmentq submit`.
    """

    packs: Sequence[Path]
    copies: int
    options: Sequence[str]


class Home:
    """A home in a folder, and the commands on it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def call(self, *words: str) -> list[dict[str, Any]]:
        """Return the JSON lines that a command prints."""
        line = [sys.executable, "-m", "garmentq.cli.main", *words, "--home", str(self.folder), "--json"]
        told = subprocess.run(line, env=make_environment(ROOT), capture_output=True, text=True, check=False)
        if told.returncode:
            raise SystemExit(f"{' '.join(words[:2])}: {told.stderr.strip()[-400:]}")
        return [json.loads(row) for row in told.stdout.splitlines()]

    def submit(self, batch: Batch) -> list[tuple[str, str]]:
        """Return the name and the job of each submission."""
        jobs = []
        for pack in batch.packs:
            words = ["submit", str(pack / "garment.ply"), "--body", str(pack / "body.ply"), "--force", *batch.options]
            words += ["--template", str(pack / "template.json")] if (pack / "template.json").exists() else []
            for copy in range(batch.copies):
                jobs.append((f"{pack.name}.{copy}", self.call(*words)[0]["job"]))
        return jobs

    def wait(self) -> None:
        """Wait until no job is left; the table is read here, since a command a second would take the workers' CPU.

        Raises:
            SystemExit: where one has failed.
        """
        database = Database(read_settings(home=self.folder).database)
        while set(states := count_states(database)) != {State.SUCCEEDED}:
            if State.FAILED in states or State.CANCELLED in states:
                raise SystemExit(f"not all succeeded: {states}")
            time.sleep(1.0)
        database.dispose()

    def hash_results(self, jobs: Sequence[tuple[str, str]]) -> dict[str, str]:
        """Return the hash of each of the results' `SAME_FILES` by the submission's name and the file's."""
        found = {}
        for name, job in jobs:
            out = self.folder / "results" / name
            self.call("export", job, "--out", str(out))
            for file in SAME_FILES:
                if (out / file).exists():
                    found[f"{name}/{file}"] = hashlib.sha256((out / file).read_bytes()).hexdigest()
        return found


def run(batch: Batch, workers: int) -> tuple[float, dict[str, str]]:
    """Return the seconds that a batch takes with some workers, and the hashes of its results."""
    with tempfile.TemporaryDirectory(prefix="garmentq-batch-") as folder:
        home = Home(Path(folder))
        jobs = home.submit(batch)
        begun = time.monotonic()
        home.call("up", "--workers", str(workers))
        try:
            home.wait()
            seconds = time.monotonic() - begun
            return seconds, home.hash_results(jobs)
        finally:
            home.call("down")


def main() -> None:
    """Print a row for each number of workers, and which files differ."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packs", nargs="+", type=Path)
    parser.add_argument("--copies", type=int, default=1)
    parser.add_argument("--workers", type=int, action="append", help="jobs at a time; may be repeated; 1 and 2 without")
    parser.add_argument("--quality", default="standard")
    parser.add_argument("--redrape", default="later")
    given = parser.parse_args()
    batch = Batch(given.packs, given.copies, ("--quality", given.quality, "--redrape", given.redrape))
    count = len(given.packs) * given.copies
    first: dict[str, str] = {}
    changed: set[str] = set()
    print("| workers | jobs | wall [s] | jobs a core-hour | jobs an hour |\n|---|---|---|---|---|")
    for workers in given.workers or [1, 2]:
        seconds, found = run(batch, workers)
        hourly = 3600.0 * count / seconds
        print(f"| {workers} | {count} | {seconds:.0f} | {hourly / workers:.0f} | {hourly:.0f} |", flush=True)
        first = first or found
        changed |= {name for name in first | found if first.get(name) != found.get(name)}
    print(f"{len(first)} files, {len(changed)} of them differ{': ' if changed else ''}{', '.join(sorted(changed))}")
    sys.exit(bool(changed))


if __name__ == "__main__":
    main()
