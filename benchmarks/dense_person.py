"""What a dense raw scan costs, from the file to the labels, and which cuts it shows, each in a process of its own.

OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/dense_person.py [SCAN] [--only NAME]

The scan (the example person unless one is given) is refined by bisecting its longest edges, with 0.2 mm of noise on all
points, or sampled as a cloud. Status 1 where one needs more CPU seconds or memory than it may, or shows other cuts than
the first.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from garmentq.cli.bench.raw_file import RawFile, read_raw_file, write_raw_file
from garmentq.cli.bench.raw_target import StageClock, spent_seconds
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.geometry.geometry import edge_lengths, vertex_normals
from garmentq.core.geometry.surface import TriangleSurface

PERSON = Path(__file__).parents[1] / "examples" / "data" / "person.ply"

NOISE = 2e-4
"""Standard deviation of the noise along the normals [m], as of a structured-light scanner."""


@dataclass(frozen=True)
class Case:
    """Name a scan and what it may cost.

    Attributes:
        make: From the coarse scan to the dense one.
        seconds: CPU seconds.
        megabytes: Peak memory of the process [MB].
    """

    make: Callable[[RawFile], RawFile]
    seconds: float
    megabytes: float


def refine(raw: RawFile, count: int) -> RawFile:
    """Bisect edges that are the longest of all their faces until there are `count` points; the surface stays closed."""
    points, faces, colours = raw.points, raw.faces, raw.colours
    while len(points) < count:
        edges = HalfEdges.of(faces, len(points))
        length = edge_lengths(points, edges.edges)
        own = edges.edge.reshape(-1, 3)
        longest = np.argmax(length[own] + 1e-9 * own, axis=1)  # a tie goes to the later edge in both faces
        wanted = np.bincount(own[np.arange(len(own)), longest], minlength=len(length)) == edges.face_counts
        chosen = np.flatnonzero(wanted)
        chosen = chosen[np.argsort(-length[chosen], kind="stable")][: count - len(points)]
        middle = np.full(len(length), -1)
        middle[chosen] = len(points) + np.arange(len(chosen))
        split = np.flatnonzero(middle[own[np.arange(len(own)), longest]] >= 0)
        turned = (longest[split][:, None] + [0, 1, 2]) % 3
        a, b, c = np.take_along_axis(faces[split], turned, axis=1).T
        m = middle[own[split, longest[split]]]
        kept = np.delete(faces, split, axis=0)
        ends = edges.edges[chosen]
        faces = np.concatenate([kept, np.stack([a, m, c], axis=1), np.stack([m, b, c], axis=1)])
        points = np.concatenate([points, points[ends].mean(axis=1)])
        if colours is not None:
            colours = np.concatenate([colours, colours[ends].mean(axis=1).astype(np.uint8)])
    noise = np.random.default_rng(0).normal(0.0, NOISE, len(points))
    return RawFile(points + noise[:, None] * vertex_normals(points, faces), faces, None, colours)


def sample(raw: RawFile, count: int) -> RawFile:
    """Draw points of the surface, with noise."""
    rng = np.random.default_rng(0)
    surface = TriangleSurface(raw.points, raw.faces)
    points, face = surface.sample(count, rng)
    points = points + rng.normal(0.0, NOISE, (count, 1)) * surface.face_normals[face]
    colours = None if raw.colours is None else raw.colours[raw.faces[face, 0]]
    return RawFile(points, raw.faces[:0], None, colours)


CASES = {
    "as it is": Case(lambda raw: raw, 15.0, 1000.0),
    "150 000 vertices": Case(lambda raw: refine(raw, 150_000), 15.0, 1000.0),
    "2 million faces": Case(lambda raw: refine(raw, 1_000_000), 60.0, 2000.0),
    "cloud of 1 million": Case(lambda raw: sample(raw, 1_000_000), 60.0, 2000.0),
}
"""A closed surface has twice as many faces as vertices."""


def take_apart(path: Path) -> dict[str, object]:
    """Read a scan and take it apart in this process; return what that cost, and the cut that each garment shows."""
    from garmentq.core.people.garments import build_person_surface, extract_garment
    from garmentq.core.people.separate import label_person
    from garmentq.core.recover.recovery import Request
    from garmentq.core.recover.start import choose_base, read_case
    from garmentq.core.run.clock import Clock
    from garmentq.core.scan.load_raw import load_raw

    start, seconds = spent_seconds(), {}
    clock = StageClock(seconds)
    with clock.stage("load"):
        raw = load_raw(path)
    with clock.stage("separate") as hooks:
        separation = label_person(raw, hooks=hooks)
    peaks = [resource.getrusage(who).ru_maxrss / 1e3 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    spent = spent_seconds() - start
    surface = build_person_surface(raw, separation.body)
    readings = [extract_garment(surface, separation, garment.part) for garment in separation.garments]
    cuts = [choose_base(read_case(Request(path, reading=reading), Clock())).template for reading in readings]
    return {"seconds": spent, "stages": seconds, "peaks": peaks, "cuts": cuts}


def main() -> int:
    """Print a row for each case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scan", nargs="?", type=Path, default=PERSON)
    parser.add_argument("--only", choices=[*CASES])
    parser.add_argument("--one", action="store_true", help="Take this scan apart here, and print JSON.")
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(take_apart(arguments.scan)))
        return 0
    coarse, wrong, cuts = read_raw_file(arguments.scan), 0, []
    print("| scan | points | faces | load [CPU s] | separate | all | may | MB here, reading | may | cuts |")
    print("|" + "---|" * 10)
    for name, case in CASES.items():
        if arguments.only not in (None, name):
            continue
        with tempfile.TemporaryDirectory() as folder:
            dense = case.make(coarse)
            path = write_raw_file(dense, Path(folder) / "scan.ply")
            command = [sys.executable, __file__, str(path), "--one"]
            told = subprocess.run(command, stdout=subprocess.PIPE, text=True).stdout
        if not told:
            wrong += 1
            print(f"| {name} | {len(dense.points)} | {len(dense.faces)} | failed |", flush=True)
            continue
        cost = json.loads(told)
        load = cost["stages"].get("load", 0.0)
        cuts = cuts or cost["cuts"]
        wrong += cost["seconds"] > case.seconds or max(cost["peaks"]) > case.megabytes or cost["cuts"] != cuts
        peaks = ", ".join(f"{peak:.0f}" for peak in cost["peaks"])
        rest = cost["seconds"] - load
        print(
            f"| {name} | {len(dense.points)} | {len(dense.faces)} | {load:.1f} | {rest:.1f} | {cost['seconds']:.1f} | "
            f"{case.seconds:.0f} | {peaks} | {case.megabytes:.0f} | {' '.join(cost['cuts'])} |",
            flush=True,
        )
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
