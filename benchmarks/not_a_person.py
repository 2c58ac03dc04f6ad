"""What becomes of scans that hold no whole person, or several: each must be refused with a code in under 20 s of CPU.

OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/not_a_person.py [NAME ...] [--keep DIR]

Six chairs, six animals on four legs and three rooms are made of blended solids (`implicit_things.py`); pairs of persons
and halves of the example person, without its labels. The example person itself comes first: it must not be refused.
Status 1 where anything went otherwise.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from garmentq.cli.bench.raw_file import RawFile, read_raw_file, write_raw_file
from garmentq.cli.bench.raw_target import spent_seconds
from garmentq.core.run.errors import GarmentqError

sys.path.insert(0, str(Path(__file__).parent))

from implicit_things import ANIMALS, CHAIRS, ROOMS, make_surface

PERSON = Path(__file__).parents[1] / "examples" / "data" / "person.ply"
LIMIT = 20.0
"""CPU seconds that a refusal may take."""

APART = 1.6
"""Distance between two persons who stand apart [m]: their hands, 60 cm from the middle, stay 40 cm away."""

ROOM_STEP = 0.025
"""Grid of a room [m]: one scanned as a whole is coarser than a chair."""


@dataclass(frozen=True)
class Result:
    """Find what became of one scan: a code, or none where it was taken for a person; CPU seconds and a message."""

    code: str | None
    seconds: float
    message: str


def read_person() -> RawFile:
    """Read the example person; nothing but its surface and colours."""
    return read_raw_file(PERSON)


def join(first: RawFile, second: RawFile) -> RawFile:
    """Return both in one file."""
    faces = np.concatenate([first.faces, second.faces + len(first.points)])
    colours = np.concatenate([first.colours, second.colours])
    return RawFile(np.concatenate([first.points, second.points]), faces, None, colours)


def move(person: RawFile, x: float, angle: float) -> RawFile:
    """Turn a person about the vertical [rad] and move it aside [m]."""
    cos, sin = np.cos(angle), np.sin(angle)
    points = person.points @ np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]]) + [x, 0.0, 0.0]
    return RawFile(points, person.faces, None, person.colours)


def cut(person: RawFile, kept: np.ndarray) -> RawFile:
    """Return what is left of a person at some of its points."""
    return person.take(np.flatnonzero(kept))


def list_persons() -> dict[str, RawFile]:
    """Return what is made of the example person, by name."""
    person = read_person()
    low, high = person.points.min(axis=0), person.points.max(axis=0)
    x, y = person.points[:, 0], person.points[:, 1]
    waist, middle = 0.6 * high[1] + 0.4 * low[1], 0.5 * (low[0] + high[0])
    return {
        "two persons apart": join(person, move(person, APART, 0.7)),
        "two persons touching": join(person, move(person, 0.98 * (high[0] - low[0]), 0.0)),
        "two persons side by side": join(person, move(cut(person, x < middle + 0.3), 0.45, 0.0)),
        "upper half": cut(person, y > waist),
        "lower half": cut(person, y < waist),
        "left half": cut(person, x > middle),
    }


def list_things() -> dict[str, RawFile]:
    """Return all that must be refused, by name."""
    found = {}
    for step, things in ((None, CHAIRS | ANIMALS), (ROOM_STEP, ROOMS)):
        for index, (name, pieces) in enumerate(things.items()):
            points, faces = make_surface(pieces, index, *([step] if step else []))
            found[name] = RawFile(points, faces)
    return found | list_persons()


def take_apart(path: Path) -> Result:
    """Read a scan and take it apart."""
    from garmentq.core.people.hints import Hints
    from garmentq.core.people.separate import label_person
    from garmentq.core.scan.load_raw import load_raw

    start = spent_seconds()
    try:
        problem = label_person(load_raw(path), Hints()).problem
    except GarmentqError as error:
        problem = error
    code, message = (None, "") if problem is None else (problem.code, problem.message)
    return Result(code, spent_seconds() - start, message)


def main() -> int:
    """Print a row for each scan."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--keep", type=Path, help="Keep the files in this folder.")
    arguments = parser.parse_args()
    wrong = 0
    print("| scan | points | code | CPU s | |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for name, scan in ({"person": read_person()} | list_things()).items():
            if arguments.names and name not in arguments.names:
                continue
            result = take_apart(write_raw_file(scan, folder / f"{name.replace(' ', '_')}.ply"))
            bad = (result.code is not None) if name == "person" else (result.code is None or result.seconds > LIMIT)
            wrong += bad
            words = f"{'WRONG ' if bad else ''}{result.message[:90]}"
            print(f"| {name} | {len(scan.points)} | {result.code} | {result.seconds:.1f} | {words} |", flush=True)
    print(f"\n{wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
