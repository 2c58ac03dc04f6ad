"""Recover what nobody has looked at: garments and dressed persons that a seed draws, made by other programs.

    make unseen SEED=n COUNT=k [FINISHED=1] [LAYERED=1] [AGAINST=commit] [GARMENTCODE=path] BLENDER=python

Even targets are one garment, scanned with noise and holes, its wearer known; odd ones are dressed persons, scanned
whole without labels. Each is recovered with its maker's base pattern and with the library alone. What is made and run
lies in `out/unseen/SEED` and is not done again; the table goes to `docs/lab/unseen-SEED.md`. A seed is used once: what
was looked at is no longer unseen.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from bench_runs import MODES, Job, find_version, run_jobs
from changed_tree import ROOT
from compare import add_options, compare_versions
from garmentq.core.run.errors import GarmentqError
from unseen_draw import Target, draw_layered, draw_target, finish
from unseen_packs import Tools, Unusable, make_pack
from unseen_table import describe_targets, format_set
from unseen_wearer import name_source

ATTEMPTS = 4
"""Targets that are drawn in place of one that crumples or that its program does not draft."""

LAB = ROOT / "docs" / "lab"


@dataclass(frozen=True)
class Draw:
    """Describe what is drawn, and by whom it is made.

    Attributes:
        seed: Of all targets.
        out: Where they are kept.
        tools: Who drafts and drapes.
        finished: Whether each target wears a top with a front, a collar or a hood, `FINISHES`.
        layered: Whether each target is a person in an outer layer, open or closed in turn.
    """

    seed: int
    out: Path
    tools: Tools
    finished: bool = False
    layered: bool = False

    @property
    def programs(self) -> tuple[str, ...]:
        """Return who drafts."""
        return ("own", "garmentcode") if self.tools.garmentcode else ("own",)

    @property
    def solvers(self) -> tuple[str, ...]:
        """Return who drapes."""
        return ("blender", "newton") if self.tools.newton else ("blender",)

    def draw(self, index: int, attempt: int) -> Target:
        """Return a target; the next attempt is another one of the same kind."""
        if self.layered:
            return draw_layered(self.seed, index, "blender", attempt)
        target = draw_target(self.seed, index, self.programs, self.solvers, attempt)
        return finish(target) if self.finished else target

    def make(self, index: int) -> dict[str, Any]:
        """Make one target unless it is there, another one where that cannot be made, and return what became of it."""
        record = self.out / "drawn" / f"{index:02d}.json"
        if record.exists():
            found: dict[str, Any] = json.loads(record.read_text())
            return found
        told: dict[str, Any] = {"name": None, "not_made": []}
        for attempt in range(ATTEMPTS):
            target = self.draw(index, attempt)
            try:
                if not (self.out / "packs" / target.name).is_dir():
                    make_pack(target, self.out / "packs", self.tools)
            except (Unusable, GarmentqError, subprocess.CalledProcessError) as error:
                told["not_made"].append(f"{target.name}: {error}")
                continue
            told["name"] = target.name
            break
        record.parent.mkdir(parents=True, exist_ok=True)
        record.write_text(json.dumps(told, indent=1))
        print(f"{index}: {told}", file=sys.stderr, flush=True)
        return told


def main() -> None:
    """Make, run, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--against", help="a commit that runs on the same targets")
    parser.add_argument("--blender", required=True, help="Python that has the module bpy")
    parser.add_argument("--newton", help="Python that has Newton, which then drapes half of the targets")
    parser.add_argument("--garmentcode", type=Path, help="a checkout of GarmentCode")
    parser.add_argument(
        "--garmentcode-python", default=sys.executable, help="Python that has what GarmentCode asks for"
    )
    parser.add_argument("--mode", action="append", choices=tuple(MODES), help="may be repeated; without: base, library")
    parser.add_argument("--finished", action="store_true", help="tops with fronts, collars and hoods, and plain ones")
    parser.add_argument("--layered", action="store_true", help="persons in an outer layer, open and closed in turn")
    parser.add_argument("--packs-only", action="store_true", help="make the targets, recover nothing")
    add_options(parser)
    given = parser.parse_args()
    given.out = (ROOT / "out" / "unseen" / str(given.seed)).resolve()
    tools = Tools(
        given.blender, given.newton, given.garmentcode and given.garmentcode.resolve(), given.garmentcode_python
    )
    with ProcessPoolExecutor(given.processes) as pool:
        drawn = list(
            pool.map(Draw(given.seed, given.out, tools, given.finished, given.layered).make, range(given.count))
        )
    packs = [given.out / "packs" / told["name"] for told in drawn if told["name"]]
    if given.packs_only:
        return
    version = find_version(None, given.out)
    modes = given.mode or ("base", "library")
    jobs = {mode: [Job(version, pack, mode) for pack in packs] for mode in modes}
    lines = run_jobs([job for mode in modes for job in jobs[mode]], given.out, given.processes)
    told = [
        f"# Seed {given.seed}, {len(packs)} of {given.count} targets, {version.name}", "",
        f"Measured: {date.today()}. Wearers: {name_source()}. Distances in mm to the truth; `s2t` from ours to it, "
        "hidden cloth of persons included.", "", *describe_targets(packs),
    ]  # fmt: skip
    for n, mode in enumerate(modes):
        own = lines[n * len(packs) : (n + 1) * len(packs)]
        told += ["", f"## {mode}", *format_set(jobs[mode], own, given.out)]
    told += ["", *(f"- not made: {line}" for one in drawn for line in one["not_made"])]
    if given.against:
        before = find_version(given.against, given.out)
        told += ["", f"## {before.name} -> {version.name}"]
        told += [compare_versions(packs, (before, version), mode, given) for mode in modes]
    text = "\n".join(told).rstrip() + "\n"
    LAB.mkdir(parents=True, exist_ok=True)
    (LAB / f"unseen-{given.seed}.md").write_text(text)
    (given.out / "lines.json").write_text(json.dumps(lines))
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
