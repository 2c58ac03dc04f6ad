"""Dress stored results on other bodies, and count what is at rest, crosses nothing and is at most 1 mm in the body.

    garmentq bench TARGETS --method deform --out RESULTS
    python benchmarks/dress.py RESULTS [--only NAME]... [--body SPEC]... [--pose P]... [--out DIR]
    python benchmarks/dress.py RESULTS --wearer          # on their own wearers, beside their re-draped meshes
    python benchmarks/dress.py --template skirt --template trousers --body SPEC      # shipped garments

Prints one JSON object a garment, body and pose, then the counts. `told_mm` is by how much the verdict says that the
garment is too small, `ruled_mm` what a ruler on the flat panels says of the same place (`ruler.py`).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.dressed import write_dressed
from garmentq.core.deliver.ply import read_ply
from garmentq.core.reuse.wear.dressing import DressedGarment, dress_body
from garmentq.core.reuse.wear.worn import WORN_FILE_NAME, WornGarment, load_worn
from garmentq.core.run.clock import Clock
from ruler import measure_lack
from worn_template import is_valid_drape, load_worn_template

BODIES = (
    "builtin:male,height=1.85,weight=85",
    "builtin:female,height=1.60,weight=80",
    "builtin:female,height=1.75,weight=55",
)
POSES = ("A", "stride")

TRUE_MM = 10.0
"""Difference of what is told and what is ruled that is promised at most [mm]."""


def compare_told(dressed: DressedGarment) -> dict[str, dict[str, float]]:
    """Return what is told and what is ruled of each place where a garment is too small [mm]."""
    tight = [one.place for one in dressed.ease if one.value < 0.0]
    told = {one.place: round(-1e3 * one.value, 1) for one in dressed.ease if one.place in tight}
    return {"told_mm": told, "ruled_mm": {place: round(1e3 * measure_lack(dressed.worn, place), 1) for place in tight}}


def compare_redraped(dressed: DressedGarment, folder: Path) -> dict[str, float]:
    """Return how far a dressing of the wearer is from the re-draped mesh that its result holds [mm]."""
    redraped = read_ply((folder / "redrape.ply").read_bytes()).vertices
    off = np.linalg.norm(dressed.worn.garment.nodes - redraped, axis=1)
    return {
        "redrape_mean_mm": round(1e3 * float(off.mean()), 4),
        "redrape_largest_mm": round(1e3 * float(off.max()), 4),
    }


def find_garments(given: argparse.Namespace) -> Iterator[tuple[str, WornGarment, Path | None]]:
    """Return name, garment and folder of what is to be dressed."""
    for name in given.template or ():
        worn = load_worn_template(name, get_fabric("cotton_poplin"))
        if worn is not None:
            yield name, worn, None
    if given.results is not None:
        for folder in sorted(path.parent for path in given.results.glob(f"*/{WORN_FILE_NAME}")):
            if not given.only or folder.name in given.only:
                yield folder.name, load_worn(folder), folder


def main() -> None:
    """Dress all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, nargs="?")
    parser.add_argument("--only", action="append")
    parser.add_argument("--template", action="append", help="a shipped garment, several times")
    parser.add_argument("--body", action="append")
    parser.add_argument("--pose", action="append")
    parser.add_argument("--wearer", action="store_true", help="dress each wearer anew")
    parser.add_argument("--out", type=Path, help="keep each dressing in a folder of its own")
    given = parser.parse_args()
    sound = total = 0
    off: list[float] = []
    places = [("wearer", "")] if given.wearer else [(s, p) for s in given.body or BODIES for p in given.pose or POSES]
    for spec, pose in places:
        for name, worn, folder in find_garments(given):
            body = worn.body if given.wearer else builtin_body(f"{spec},pose={pose}")
            dressed = dress_body(worn, body, None, Clock())
            total, sound = total + 1, sound + is_valid_drape(dressed.report.metrics)
            line = {"garment": name, "body": spec, "pose": pose, "sound": is_valid_drape(dressed.report.metrics)}
            told = compare_told(dressed)
            off += [abs(told["told_mm"][place] - ruled) for place, ruled in told["ruled_mm"].items()]
            if given.wearer and folder is not None:
                line |= compare_redraped(dressed, folder)
            print(
                json.dumps(line | told | dressed.report.metrics | {"cpu_seconds": dressed.report.cpu_seconds}),
                flush=True,
            )
            if given.out:
                write_dressed(dressed, given.out / f"{name} {spec.replace(':', ' ')} {pose}")
    print(f"{sound} of {total} at rest, without a crossing, at most 1 mm deep")
    if off:
        true = sum(one <= TRUE_MM for one in off)
        print(f"too small as ruled: {true} of {len(off)} places within {TRUE_MM:.0f} mm, at most {max(off):.1f} mm off")


if __name__ == "__main__":
    main()
