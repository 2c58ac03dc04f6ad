"""Dress stored results on other bodies, and count what is at rest, crosses nothing and is at most 1 mm in the body.

    garmentq bench TARGETS --method deform --out RESULTS
    python benchmarks/dress.py RESULTS [--only NAME]... [--body SPEC]... [--pose P]... [--out DIR]

Prints one JSON object a garment, body and pose, then the count.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from garmentq.core.body import builtin_body
from garmentq.core.clock import Clock
from garmentq.core.export.dressed import write_dressed
from garmentq.core.wear import WORN, dress_body, is_sound, load_worn

BODIES = (
    "builtin:male,height=1.85,weight=85",
    "builtin:female,height=1.60,weight=80",
    "builtin:female,height=1.75,weight=55",
)
POSES = ("A", "stride")


def main() -> None:
    """Dress all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path)
    parser.add_argument("--only", action="append")
    parser.add_argument("--body", action="append")
    parser.add_argument("--pose", action="append")
    parser.add_argument("--out", type=Path, help="keep each dressing in a folder of its own")
    given = parser.parse_args()
    sound = total = 0
    folders = sorted(path.parent for path in given.results.glob(f"*/{WORN}"))
    for spec in given.body or BODIES:
        for pose in given.pose or POSES:
            for folder in folders:
                if given.only and folder.name not in given.only:
                    continue
                dressed = dress_body(load_worn(folder), builtin_body(f"{spec},pose={pose}"), None, Clock())
                total, sound = total + 1, sound + is_sound(dressed.metrics)
                line = {"garment": folder.name, "body": spec, "pose": pose, "sound": is_sound(dressed.metrics)}
                print(json.dumps(line | dressed.metrics | {"cpu_seconds": dressed.cpu_seconds}), flush=True)
                if given.out:
                    write_dressed(dressed, given.out / f"{folder.name} {spec.replace(':', ' ')} {pose}")
    print(f"{sound} of {total} at rest, without a crossing, at most 1 mm deep")


if __name__ == "__main__":
    main()
