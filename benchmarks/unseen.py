"""Recover what nobody has looked at: garments and dressed persons that a seed draws, made by other programs.

    make unseen SEED=n COUNT=k [AGAINST=commit] [GARMENTCODE=path] BLENDER=python

Even targets are one garment, scanned with noise and holes, its wearer known; odd ones are dressed persons, scanned
whole without labels. Each is recovered with its maker's base pattern and with the library alone. What is made and run
lies in `out/unseen/SEED` and is not done again; the table goes to `docs/lab/unseen-SEED.md`. A seed is used once: what
was looked at is no longer unseen.
"""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from bench_runs import MODES, ROOT, Job, find_version, run_jobs
from compare import add_options, compare_versions
from garmentq.core.errors import GarmentqError
from unseen_draw import Target, draw_targets
from unseen_packs import Tools, Unusable, make_pack
from unseen_table import describe_targets, format_set
from unseen_wearer import name_source

LAB = ROOT / "docs" / "lab"


def make_packs(targets: tuple[Target, ...], out: Path, tools: Tools, processes: int) -> list[Path]:
    """Make the packs that are not there yet and return the folders of those that could be made."""
    (out / "packs").mkdir(parents=True, exist_ok=True)
    open_targets = [one for one in targets if not _is_done(one, out)]
    with ProcessPoolExecutor(processes) as pool:
        for target, problem in zip(
            open_targets, pool.map(_make, [(one, out, tools) for one in open_targets]), strict=True
        ):
            print(f"{target.name}: {problem or 'made'}", file=sys.stderr, flush=True)
    return [out / "packs" / one.name for one in targets if (out / "packs" / one.name).is_dir()]


def _is_done(target: Target, out: Path) -> bool:
    return (out / "packs" / target.name).is_dir() or (out / f"{target.name}.unusable").exists()


def _make(given: tuple[Target, Path, Tools]) -> str:
    target, out, tools = given
    try:
        make_pack(target, out / "packs", tools)
    except (Unusable, GarmentqError) as error:
        (out / f"{target.name}.unusable").write_text(str(error))
        return str(error)
    return ""


def main() -> None:
    """Make, run, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--against", help="a commit that runs on the same targets")
    parser.add_argument("--blender", required=True, help="Python that has the module bpy")
    parser.add_argument("--garmentcode", type=Path, help="a checkout of GarmentCode")
    parser.add_argument(
        "--garmentcode-python", default=sys.executable, help="Python that has what GarmentCode asks for"
    )
    parser.add_argument("--mode", action="append", choices=tuple(MODES), help="may be repeated; both without")
    parser.add_argument("--packs-only", action="store_true", help="make the targets, recover nothing")
    add_options(parser)
    given = parser.parse_args()
    given.out = (ROOT / "out" / "unseen" / str(given.seed)).resolve()
    programs = ("own", "garmentcode") if given.garmentcode else ("own",)
    targets = draw_targets(given.seed, given.count, programs, ("blender",))
    tools = Tools(given.blender, given.garmentcode and given.garmentcode.resolve(), given.garmentcode_python)
    packs = make_packs(targets, given.out, tools, given.processes)
    if given.packs_only:
        return
    version = find_version(None, given.out)
    modes = given.mode or tuple(MODES)
    jobs = {mode: [Job(version, pack, mode) for pack in packs] for mode in modes}
    lines = run_jobs([job for mode in modes for job in jobs[mode]], given.out, given.processes)
    told = [
        f"# Seed {given.seed}, {len(packs)} of {given.count} targets, {version.name}", "",
        f"Wearers: {name_source()}. Distances in mm to the truth; `s2t` from ours to it.", "", *describe_targets(packs),
    ]  # fmt: skip
    for n, mode in enumerate(modes):
        own = lines[n * len(packs) : (n + 1) * len(packs)]
        told += ["", f"## {mode}", *format_set(jobs[mode], own, given.out)]
    unusable = sorted(given.out.glob("*.unusable"))
    told += ["", *(f"Not made: {path.stem}: {path.read_text()}" for path in unusable)]
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
