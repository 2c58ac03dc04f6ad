"""Grade base patterns, drape each size on a body by its measures, and count what is at rest without a crossing.

The wearer is the built-in female body of 1.70 m in a shipped drape; sizes are -2..4 steps of 4 cm. Run with
OMP_NUM_THREADS=1, OPENBLAS_NUM_THREADS=1 and NUMBA_NUM_THREADS=1:
python benchmarks/sizes.py [TEMPLATE]... [--fabric NAME] [--only SIZE] [--out DIR]

Prints one JSON object a size, then the count.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.dressed_report import draw_wearers
from garmentq.core.deliver.formats.grading import grade_sizes
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.deliver.formats.size_drapes import drape_size
from garmentq.core.recover.drape.sizing import measure_wearer
from worn_template import is_valid_drape, load_worn_template

TEMPLATES = ("tshirt", "trousers", "skirt", "dress")


def main() -> None:
    """Drape all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("templates", nargs="*", default=TEMPLATES)
    parser.add_argument("--fabric", default="single_jersey")
    parser.add_argument("--only", action="append", help="a size by its name, several times")
    parser.add_argument("--out", type=Path, help="draw each size here")
    given = parser.parse_args()
    sound = total = 0
    for name in given.templates:
        worn = load_worn_template(name, get_fabric(given.fabric))
        if worn is None:
            raise SystemExit("no drape is shipped for this machine's triangulation")
        base = measure_wearer(worn.body)
        options = ExportOptions("sizes", first=-2, last=4)
        for size in grade_sizes(worn.pattern, name, base, 1.70, options):
            if given.only and size.name not in given.only:
                continue
            dressed = drape_size(worn, size, base)
            total, sound = total + 1, sound + is_valid_drape(dressed.report.metrics)
            line = {
                "template": name,
                "size": size.name,
                "sound": is_valid_drape(dressed.report.metrics),
                **dressed.report.metrics,
            }
            print(json.dumps(line | {"cpu_seconds": round(dressed.report.cpu_seconds, 1)}), flush=True)
            if given.out:
                given.out.mkdir(parents=True, exist_ok=True)
                (given.out / f"{name}_{size.name}.png").write_bytes(draw_wearers(dressed))
    print(f"{sound} of {total} at rest, without a crossing, at most 1 mm deep")


if __name__ == "__main__":
    main()
