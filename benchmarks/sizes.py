"""Grade patterns to seven sizes, compare each figure with its rule, and drape each size on a body by its measures.

The wearer is the built-in female body of 1.70 m in a shipped drape; sizes are -2..4 steps of 4 cm. `shirt` is a
long-sleeved shirt with set-in sleeves without any name, label or note, as from another program: its points are found by
how its panels meet. Run with OMP_NUM_THREADS=1, OPENBLAS_NUM_THREADS=1 and NUMBA_NUM_THREADS=1:
python benchmarks/sizes.py [TEMPLATE]... [--fabric NAME] [--only SIZE] [--flat] [--out DIR]

Prints one JSON object a size, then the count.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.dressed_report import draw_wearers
from garmentq.core.deliver.formats.grade_table import make_grade_table
from garmentq.core.deliver.formats.grading import Size, grade_sizes
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.deliver.formats.size_drapes import drape_size
from garmentq.core.garment.contour_edges import name_open_edges
from garmentq.core.garment.grain import place_grains
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.pieces.trueing import true_pattern
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import DRAPED_VERTICES, load_template
from garmentq.core.recover.drape.shipped import TEMPLATE_WEARER
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.reuse.wear.dressing import dress_body
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.run.clock import Clock
from garmentq.core.run.hooks import SILENT_HOOKS
from worn_template import is_valid_drape, load_worn_template

TEMPLATES = ("tshirt", "trousers", "skirt", "dress", "shirt")

SHIRT_CUT = "tshirt+sleeve=long,sleeve_head=set-in"
"""Cut of the shirt."""


def main() -> None:
    """Grade and drape all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("templates", nargs="*", default=TEMPLATES)
    parser.add_argument("--fabric", default="single_jersey")
    parser.add_argument("--only", action="append", help="a size by its name, several times")
    parser.add_argument("--flat", action="store_true", help="compare figures with rules only, drape nothing")
    parser.add_argument("--out", type=Path, help="draw each size here")
    given = parser.parse_args()
    sound = total = 0
    worst = 0.0
    for name in given.templates:
        worn = (
            wear_shirt(get_fabric(given.fabric))
            if name == "shirt"
            else load_worn_template(name, get_fabric(given.fabric))
        )
        if worn is None:
            raise SystemExit("no drape is shipped for this machine's triangulation")
        base, options = measure_wearer(worn.body), ExportOptions("sizes", first=-2, last=4)
        trued = true_pattern(name_open_edges(worn.garment)).pattern
        sizes = grade_sizes(trued, worn.template, base, 1.70, options)
        for size in sizes:
            if given.only and size.name not in given.only:
                continue
            line = {"template": name, "size": size.name, **describe_size(sizes, size)}
            worst = max(worst, line["largest_cut_error_mm"])
            if not given.flat:
                dressed = drape_size(worn, size)
                is_sound = is_valid_drape(dressed.report.metrics)
                total, sound = total + 1, sound + is_sound
                line |= {"sound": is_sound, "cpu_seconds": round(dressed.report.cpu_seconds, 1)}
                line |= dressed.report.metrics
                if given.out:
                    given.out.mkdir(parents=True, exist_ok=True)
                    (given.out / f"{name}_{size.name}.png").write_bytes(draw_wearers(dressed))
            print(json.dumps(line), flush=True)
    print(
        f"{sound} of {total} at rest, without a crossing, at most 1 mm deep; "
        f"figures of cut pieces within {worst:.3f} mm of rules"
    )


def wear_shirt(fabric: Fabric) -> WornGarment:
    """Return a shirt of another program on the built-in female body."""
    body = builtin_body(TEMPLATE_WEARER)
    garment = mesh_pattern(forget_names(load_template(SHIRT_CUT)), DRAPED_VERTICES)
    worn = WornGarment(garment, fabric, body, None, None, "shirt", "long_sleeve_tshirt")
    return dress_body(worn, body, None, Clock(SILENT_HOOKS)).worn


def forget_names(pattern: Pattern) -> Pattern:
    """Return a pattern as a file without notes has it: panels by number, no labels, contours or notches."""
    numbers = {panel.name: f"p{n}" for n, panel in enumerate(pattern.panels)}
    panels = tuple(
        replace(
            panel,
            name=numbers[panel.name],
            label="",
            notches=(),
            edges=tuple(replace(edge, label="", contour="") for edge in panel.edges),
        )
        for panel in pattern.panels
    )
    seams = tuple(
        replace(seam, a=replace(seam.a, panel=numbers[seam.a.panel]), b=replace(seam.b, panel=numbers[seam.b.panel]))
        for seam in pattern.seams
    )
    return place_grains(replace(pattern, name="shirt", panels=panels, seams=seams, extra={}))


def describe_size(sizes: list[Size], size: Size) -> dict[str, float]:
    """Return the largest difference of a figure from its rule, in the pattern and in the pieces that are cut of it, and
    what follows from the rules of sleeves [mm]."""
    base = next(one for one in sizes if one.is_base)
    cut, errors, cut_errors = true_pattern(size.pattern).pattern, [0.0], [0.0]
    for before, after in zip(base.figures, size.figures, strict=True):
        due = before.value(base.pattern) + before.rule.grow(size.growth, before.value(base.pattern))
        errors.append(abs(after.value(size.pattern) - due))
        cut_errors.append(abs(after.value(cut) - due))
    k = sizes.index(size)
    follows = ("bicep", "cap height", "underarm seam", "armhole seam", "cap ease")
    rows = {row.figure: 1e3 * row.growth[k] for row in make_grade_table(sizes)}
    grown = {f"{name.replace(' ', '_')}_growth_mm": round(rows[name], 3) for name in follows if name in rows}
    worst = {"largest_error_mm": round(1e3 * max(errors), 6), "largest_cut_error_mm": round(1e3 * max(cut_errors), 3)}
    return worst | {"is_drafted": float(size.is_drafted), **grown}


if __name__ == "__main__":
    main()
