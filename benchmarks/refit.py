"""Make shipped templates to the measures of ten bodies: ease as foreseen and as draped, identity, there and back.

Run with OMP_NUM_THREADS=1, OPENBLAS_NUM_THREADS=1 and NUMBA_NUM_THREADS=1:
python benchmarks/refit.py [TEMPLATE]... [--body N]... [--fabric NAME] [--out DIR]

Prints one JSON object a garment and body, then for each garment and place the largest change of the ease and the count
of those within 5 mm.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.dressed_report import draw_wearers
from garmentq.core.garment.pattern import Pattern
from garmentq.core.reuse.wear.dressing import dress_body
from garmentq.core.reuse.wear.ease import measure_ease
from garmentq.core.reuse.wear.kept_ease import EasePrediction
from garmentq.core.reuse.wear.refit import make_to_measure, refit_pattern
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.run.clock import Clock
from worn_template import is_valid_drape, load_worn_template

TEMPLATES = ("tshirt", "trousers", "skirt", "dress")

BODIES = tuple(
    f"builtin:{gender},height={height},weight={weight},chest={chest},waist={waist},hip={hip}"
    for gender, height, weight, chest, waist, hip in (
        ("female", 1.55, 50, 0.87, 0.70, 0.95),
        ("female", 1.60, 80, 1.08, 0.92, 1.17),
        ("female", 1.63, 58, 0.90, 0.72, 1.03),
        ("female", 1.70, 65, 0.98, 0.80, 1.03),
        ("female", 1.76, 90, 1.10, 0.93, 1.18),
        ("male", 1.65, 60, 0.98, 0.77, 0.97),
        ("male", 1.72, 95, 1.18, 1.04, 1.13),
        ("male", 1.78, 75, 1.06, 0.87, 1.01),
        ("male", 1.85, 85, 1.11, 0.92, 1.06),
        ("male", 1.90, 100, 1.18, 1.00, 1.11),
    )
)
"""Ten people by what their file of measures would give: height, weight, chest, waist and hip."""

KEPT_MM = 5.0
"""Change of the ease that is promised at most [mm]."""


def measure_one(worn: WornGarment, spec: str) -> dict[str, object]:
    """Return what becomes of a garment's ease and control points on one body and back, in mm."""
    body = builtin_body(spec)
    dressed = make_to_measure(worn, body, None, Clock())
    made = dressed.worn.pattern
    foreseen = EasePrediction.of(worn.garment, worn.body, worn.waist, body).predict_change(made)
    back = refit_pattern(dressed.worn, worn.body).pattern
    line: dict[str, object] = {"body": spec, "sound": is_valid_drape(dressed.report.metrics)}
    line |= {"foreseen_mm": _in_mm(foreseen), "draped_mm": _changes(dressed.report.metrics)}
    line |= {"ease_mm": _in_mm({one.place: one.value for one in dressed.ease})}
    line |= {"there_and_back_mm": _furthest(back, worn.pattern), "moved_mm": _furthest(made, worn.pattern)}
    return line | {"cpu_seconds": round(dressed.report.cpu_seconds, 1), "dressed": dressed}


def _changes(metrics: dict[str, float | None]) -> dict[str, float]:
    """Return the changes of the ease by place [mm]."""
    head, tail = "ease_change.", "_mm"
    return {k[len(head) : -len(tail)]: round(v, 1) for k, v in metrics.items() if k.startswith(head) and v is not None}


def _in_mm(lengths: dict[str, float]) -> dict[str, float]:
    return {place: round(1e3 * value, 1) for place, value in lengths.items()}


def _furthest(one: Pattern, other: Pattern) -> float:
    """Return the largest distance of two patterns' control points [mm]."""
    return round(1e3 * float(np.linalg.norm(one.points - other.points, axis=1).max()), 3)


def keep_on(worn: WornGarment, wearer: Body) -> dict[str, float]:
    """Return the change of the ease where the unchanged pattern is draped anew on its own wearer, by place [mm]."""
    before = {one.place: one.value for one in measure_ease(worn.garment, worn.body)}
    after = {one.place: one.value for one in dress_body(worn, wearer, None, Clock()).ease}
    return _in_mm({place: value - before[place] for place, value in after.items() if place in before})


def main() -> None:
    """Measure all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("templates", nargs="*", default=TEMPLATES)
    parser.add_argument("--body", action="append", type=int, help="number of a body, from 0, several times")
    parser.add_argument("--fabric", default="cotton_poplin")
    parser.add_argument("--out", type=Path, help="draw each dressing here")
    given = parser.parse_args()
    for name in given.templates:
        worn = load_worn_template(name, get_fabric(given.fabric))
        if worn is None:
            raise SystemExit("no drape is shipped for this machine's triangulation")
        same = refit_pattern(worn, worn.body).pattern
        head = {"garment": name, "identity_mm": _furthest(same, worn.pattern)}
        head |= {"ease_mm": _in_mm({one.place: one.value for one in measure_ease(worn.garment, worn.body)})}
        print(json.dumps(head | {"draped_anew_mm": keep_on(worn, worn.body)}), flush=True)
        found: dict[str, list[float]] = {}
        for number in given.body or range(len(BODIES)):
            line = measure_one(worn, BODIES[number])
            dressed = line.pop("dressed")
            for place, value in line["draped_mm"].items():
                found.setdefault(place, []).append(abs(value))
            print(json.dumps({"garment": name, "number": number} | line), flush=True)
            if given.out:
                given.out.mkdir(parents=True, exist_ok=True)
                (given.out / f"{name}_{number}.png").write_bytes(draw_wearers(dressed))
        for place, values in found.items():
            kept = sum(value <= KEPT_MM for value in values)
            print(f"{name}, {place}: at most {max(values):.1f} mm, {kept} of {len(values)} within {KEPT_MM:.0f} mm")


if __name__ == "__main__":
    main()
