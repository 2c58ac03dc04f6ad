"""Write the sizes of a garment, and with `drape` each of them on a body by its measures."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...body.measured import MeasureRange
from ...reuse.wear.dressing import DressedGarment
from ...run.verdict import Verdict, worst_verdict
from ..formats import nest
from ..formats.grading import Size
from ..formats.size_drapes import drape_size
from .dressed_report import aim_at
from .meshes import write_ply
from .person import composite_on_white
from .picture import ColouredMesh, png_base64, render_meshes
from .result import write_json
from .views import DRAPE_COLOUR, SKIN_COLOUR

if TYPE_CHECKING:
    from ..formats.production import Production


def write_sizes(production: Production, folder: Path) -> list[Path]:
    """Write patterns, nest and rules of all sizes, and with the option `drape` the drape of each; return the files.

    Of each size that is draped: `draped_SIZE.ply` and `body_SIZE.ply`; of all: `sizes.json` with verdicts and numbers,
    `sizes.png` with front and back of each.

    Raises:
        SizesBad: where sizes are not valid.
        PieceBad: where a piece of a size cannot be cut.
        Cancelled: where the hooks cancel.
    """
    files = nest.write(production, folder)
    if not production.options.drape:
        return files
    worn, sizes = production.worn, nest.grade_worn(production)
    described: list[dict[str, Any]] = []
    pictures: list[np.ndarray] = []
    for number, size in enumerate(sizes):
        production.hooks.progress("write", number / len(sizes), f"draping size {size.name}")
        try:
            dressed = drape_size(worn, size, production.hooks.quiet())
        except MeasureRange as error:
            described.append(_describe_draped_size(size, None, error.message))
            continue
        garment, body = dressed.worn.garment, dressed.worn.body
        files.append(write_ply(garment.nodes, garment.faces, folder / f"draped_{size.name}.ply"))
        files.append(write_ply(body.vertices, body.faces, folder / f"body_{size.name}.ply"))
        described.append(_describe_draped_size(size, dressed))
        pictures.append(_draw(dressed))
    files.append(write_json({"sizes": described}, folder / "sizes.json"))
    if pictures:
        picture = folder / "sizes.png"
        picture.write_bytes(base64.b64decode(png_base64(np.concatenate(pictures, axis=1))))
        files.append(picture)
    return files


def _describe_draped_size(size: Size, dressed: DressedGarment | None, reason: str = "") -> dict[str, Any]:
    """Describe a size: girths [cm], verdict, warnings, numbers; the reason if it was not draped."""
    girths = {name: round(100.0 * getattr(size.measures, name), 1) for name in ("bust", "waist", "hip")}
    values: dict[str, Any] = {"name": size.name, "is_base": size.is_base, "is_drafted": size.is_drafted, **girths}
    if dressed is None:
        return {**values, "verdict": Verdict.FAIL, "warnings": [reason], "metrics": {}}
    report = dressed.report
    gates = [{"name": gate.name, "verdict": gate.verdict, "message": gate.message} for gate in report.gates]
    verdict = worst_verdict(gate.verdict for gate in report.gates)
    return {**values, "verdict": verdict, "gates": gates, "warnings": report.warnings, "metrics": report.metrics}


def _draw(dressed: DressedGarment) -> np.ndarray:
    """Return a picture of a size from the front, above one from the back."""
    worn = dressed.worn
    surfaces = [
        ColouredMesh(worn.body.vertices, worn.body.faces, SKIN_COLOUR),
        ColouredMesh(worn.garment.nodes, worn.garment.faces, DRAPE_COLOUR),
    ]
    return np.concatenate(
        [composite_on_white(render_meshes(surfaces, aim_at(worn, turn))) for turn in (0.0, np.pi)], axis=0
    )
