"""Move recovered garments of target packs by the shipped motions, or by a file, and print what each run was worth.

    python benchmarks/animate.py ../shared/targets gpg_tee gpg_pants gc_skirt2 --motion walk --seconds 4
    python benchmarks/animate.py cuts long_sleeve_tshirt+collar=notched,front=open --motion walk --seconds 2

Recovers each pack with the method `deform`, then animates its graded drape at 4000 vertices; with `cuts` in place of a
folder of packs the names are cuts, which are draped on the built-in body. One line a garment:
frames, frames not converged, deepest point in the body, faces that cross in the worst frame, CPU seconds a frame,
and with `--half` how far a run with half the step is away (RMS of the worst frame). `--out` keeps sheet and caches.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from garmentq.cli.bench.packs import read_packs
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.motion.read import load_motion
from garmentq.core.body.motion.retarget import retarget
from garmentq.core.body.motion.shipped import find_shipped_motion
from garmentq.core.body.motion.track import LeadIn, Pose
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.animation import write_animation
from garmentq.core.garment.templates import find_cut, load_template
from garmentq.core.recover.drape.stage import drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.reuse.animate.animation import Animation, animate
from garmentq.core.reuse.animate.clearing import make_room_for_garment
from garmentq.core.reuse.animate.measured import measure_animation
from garmentq.core.reuse.animate.settings import AnimateSettings, StepLimits
from garmentq.core.reuse.wear.dressing import dress_body
from garmentq.core.reuse.wear.worn import WornGarment, worn_from_recovery
from garmentq.core.run.clock import Clock


def wear(folder: Path) -> WornGarment:
    """Return the garment of a pack as its recovery leaves it on the wearer."""
    pack = read_packs(folder)[0]
    request = Request(pack.garment, pack.body, pack.template, RecoverySettings(method="deform"))
    return worn_from_recovery(recover(request))


def wear_cut(name: str) -> WornGarment:
    """Return a cut at rest on the built-in body for which it is drafted, in A-pose."""
    stands, body = (builtin_body(f"builtin:female,height=1.70,pose={pose}") for pose in ("T", "A"))
    garment, fabric = drape_template(load_template(name), WearerGeometry(stands)), get_fabric("cotton_poplin")
    category = find_cut(name).category or "tshirt"
    worn = WornGarment(garment, fabric, stands, None, None, name, category)
    return dress_body(worn, body, fabric, Clock()).worn


def move(worn: WornGarment, motion: Path, settings: AnimateSettings) -> Animation:
    """Return the garment in motion."""
    track = retarget(load_motion(motion), worn.body, settings.begin)
    if not settings.keep_motion:
        track, _ = make_room_for_garment(worn, track, settings)
    return animate(worn, LeadIn(Pose.of(worn.body), track, settings.begin, settings.lead), settings)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", type=Path, help="folder of packs, or `cuts`")
    parser.add_argument("names", nargs="+")
    parser.add_argument("--motion", default="walk")
    parser.add_argument("--seconds", type=float, default=4.0)
    parser.add_argument("--half", action="store_true")
    parser.add_argument("--keep-motion", action="store_true")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    motion = find_shipped_motion(given.motion) or Path(given.motion)
    settings = AnimateSettings(end=given.seconds, keep_motion=given.keep_motion)
    print("| garment | frames | not converged | depth mm | crossings | CPU s a frame | half the step, mm |")
    print("|---|---|---|---|---|---|---|")
    for name in given.names:
        worn = wear_cut(name) if str(given.targets) == "cuts" else wear(given.targets / name)
        found = move(worn, motion, settings)
        told = measure_animation(found)
        away = "–"
        if given.half:
            half = StepLimits(settings.pace.travel / 2, settings.pace.longest / 2)
            fine = move(worn, motion, replace(settings, pace=half))
            away = f"{1e3 * np.sqrt(((fine.frames - found.frames) ** 2).sum(axis=2).mean(axis=1)).max():.1f}"
        print(
            f"| {name} | {told['frames']:.0f} | {told['frames_not_converged']:.0f} | {told['max_depth_mm']:.2f} | "
            f"{told['crossings']:.0f} | {told['seconds_per_frame']:.2f} | {away} |",
            flush=True,
        )
        if given.out:
            write_animation(found, given.out / f"{name}_{motion.stem}")


if __name__ == "__main__":
    main()
