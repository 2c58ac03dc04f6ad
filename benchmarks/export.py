"""Write garments in every format and dialect, and state the CPU seconds of each.

    python benchmarks/export.py [TEMPLATE | RESULT]...

A template stands for its shipped drape with colours; a result is a folder with `worn.npz`, of a recovery of a person
with the `reading.npz` that holds its colours. Run with OMP_NUM_THREADS=1, OPENBLAS_NUM_THREADS=1 and
NUMBA_NUM_THREADS=1. Prints one JSON object a garment: seconds by format, of this process and those that it waits for,
or the code of an error.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

import numpy as np
import trimesh
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.meshes import write_ply
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.deliver.formats.production import Production, write_production
from garmentq.core.deliver.formats.registry import DIALECTS, FORMATS
from garmentq.core.garment.templates import list_templates
from garmentq.core.reuse.wear.worn import WORN_FILE_NAME, load_worn, save_worn
from garmentq.core.run.errors import GarmentqError
from worn_template import load_worn_template


def make_result(name: str, folder: Path) -> Path:
    """Write a shipped drape as a recovery writes it, and return its scan: the drape with colours by height."""
    worn = load_worn_template(name, get_fabric("single_jersey"))
    if worn is None:
        raise SystemExit("no drape is shipped for this machine's triangulation")
    save_worn(worn, folder)
    garment = worn.garment
    for mesh in ("graded", "detail", "simulation", "redrape"):
        write_ply(garment.nodes, garment.faces, folder / f"{mesh}.ply")
    told = {"scan": {"name": name, "units": "m", "up": "y"}}
    (folder / "manifest.json").write_text(json.dumps(told), encoding="utf-8")
    colours = np.clip(np.repeat(150.0 * garment.nodes[:, 1:2], 3, axis=1), 0.0, 255.0).astype(np.uint8)
    scan = folder / "scan.ply"
    trimesh.Trimesh(garment.nodes, garment.faces, vertex_colors=colours, process=False).export(scan)
    return scan


def used() -> float:
    """Return the CPU seconds of this process and of those that it waited for."""
    children = getrusage(RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def write_all(result: Path, scan: Path | None) -> dict[str, float | str]:
    """Write a result in every format, and return the seconds, or the code of an error, by format."""
    found: dict[str, float | str] = {}
    cases = [(name, "") for name in FORMATS if name != "dxf"] + [("dxf", dialect) for dialect in DIALECTS]
    with tempfile.TemporaryDirectory() as out:
        for name, dialect in cases:
            start = used()
            key = f"{name} {dialect}".strip()
            options = ExportOptions(name, dialect=dialect or DIALECTS[0])
            try:
                files = write_production(Production(load_worn(result), options, result, scan), Path(out) / name)
                found[key] = round(used() - start, 2) if all(file.stat().st_size for file in files) else "empty"
            except GarmentqError as error:
                found[key] = error.code
    return found


def main() -> None:
    """Write all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("garments", nargs="*", default=[info.name for info in list_templates()])
    for name in parser.parse_args().garments:
        with tempfile.TemporaryDirectory() as folder:
            result, scan = Path(name), Path(name) / "reading.npz"
            if not (result / WORN_FILE_NAME).is_file():
                result = Path(folder)
                scan = make_result(name, result)
            found = write_all(result, scan if scan.is_file() else None)
        total = sum(value for value in found.values() if isinstance(value, float))
        print(json.dumps({"garment": name, "all": round(total, 1), **found}), flush=True)


if __name__ == "__main__":
    main()
