"""Compare two commits over target packs, raw packs or an unseen set, by the scatter of the one before.

    python benchmarks/compare.py PACKS --before COMMIT [--after COMMIT] [--mode library] [--scatter 3] [--out DIR]

Without `--after` the tree is compared as it is. The commit before runs with each scan moved by 1e-12 m as often as
`--scatter` says: that is how far its figures go by rounding alone. A figure is worse where its paired mean rises by
more than 3 % and by more than two standard errors. Lines are kept in DIR; a second call goes on where one was stopped.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from bench_compare import compare_lines, format_changes, format_verdicts
from bench_runs import MODES, Job, Version, find_version, run_jobs

SCATTER = 3
"""Runs that scatter is taken from."""


def compare_versions(packs: list[Path], versions: tuple[Version, Version], mode: str, given: argparse.Namespace) -> str:
    """Run both commits in one mode and return the comparison as text."""
    before, after = versions
    shifts = range(1, given.scatter + 1) if given.scatter else (0,)
    jobs = [Job(before, pack, mode, shift) for pack in packs for shift in shifts]
    lines = run_jobs([*jobs, *(Job(after, pack, mode) for pack in packs)], given.out, given.processes)
    each = len(shifts)
    earlier = [lines[each * n : each * (n + 1)] for n in range(len(packs))]
    later = lines[each * len(packs) :]
    by_kind: dict[bool, list[int]] = {}
    for n, line in enumerate(later):
        by_kind.setdefault("outcome" in line, []).append(n)
    told = []
    for is_raw, own in sorted(by_kind.items()):
        chosen, ends = [earlier[n] for n in own], [later[n] for n in own]
        told += [f"\n{'Raw persons' if is_raw else 'Garments'}, {mode}, {before.name} -> {after.name}\n"]
        told += format_changes(compare_lines(chosen, ends))
        told += ["", *format_verdicts([runs[0] for runs in chosen], ends)]
    return "\n".join(told)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of every comparison."""
    parser.add_argument("--scatter", type=int, default=SCATTER, help="runs of the commit before with the scan moved")
    parser.add_argument("--processes", type=int, default=2)


def main() -> None:
    """Print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("packs", type=Path)
    parser.add_argument("--before", required=True, help="a commit")
    parser.add_argument("--after", help="another one; the tree as it is without")
    parser.add_argument("--mode", action="append", choices=tuple(MODES), help="may be repeated; base without")
    parser.add_argument("--only", action="append", help="a pack's name; may be repeated")
    parser.add_argument("--out", type=Path, default=Path("out/compare"))
    add_options(parser)
    given = parser.parse_args()
    given.out = given.out.resolve()
    packs = sorted(path.parent.resolve() for path in given.packs.glob("*/meta.json"))
    packs = [pack for pack in packs if given.only is None or pack.name in given.only]
    if not packs:
        parser.error(f"{given.packs} holds no packs")
    versions = find_version(given.before, given.out), find_version(given.after, given.out)
    for mode in given.mode or ("base",):
        sys.stdout.write(compare_versions(packs, versions, mode, given) + "\n")


if __name__ == "__main__":
    main()
