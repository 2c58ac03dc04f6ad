"""Write a garment on another body into one folder."""

from __future__ import annotations

from pathlib import Path

from ...garment.garmentcode_writer import write_pattern
from ...reuse.wear.dressing import DressedGarment
from ...reuse.wear.worn import save_worn
from .dressed_report import draw_wearers, report_dressed
from .meshes import write_meshes, write_ply
from .pattern_svg import write_svg
from .result import write_body, write_json


def write_dressed(dressed: DressedGarment, folder: Path) -> list[Path]:
    """Write meshes, pattern, numbers and report of a garment on another body.

    Args:
        dressed: The garment.
        folder: Folder, created if missing; files of the same names are replaced.

    Returns:
        The files: dressed.obj, .glb, .ply (with `strain` and `pressure` [Pa] of each vertex), body.ply,
            body_joints.json, pattern.json, pattern.svg, metrics.json, manifest.json, worn.npz, picture.png,
            report.html; if it is worn over another garment, that one as under.obj, under.glb and under.ply.
    """
    worn = dressed.worn
    files = write_garment(dressed, folder)
    if dressed.inner is not None:
        below = dressed.inner.garment
        files += write_meshes(below, below.nodes, folder, "under", ("obj", "glb"))
        files.append(write_ply(below.nodes, below.faces, folder / "under.ply"))
    files += write_body(worn.body, folder)
    files.append(write_json(dressed.report.metrics, folder / "metrics.json"))
    files.append(write_json(dressed.report.manifest, folder / "manifest.json"))
    picture, report = folder / "picture.png", folder / "report.html"
    picture.write_bytes(draw_wearers(dressed))
    report.write_text(report_dressed(dressed, picture.read_bytes()), encoding="utf-8")
    return [*files, picture, report]


def write_garment(dressed: DressedGarment, folder: Path) -> list[Path]:
    """Write meshes and pattern of a garment on another body, and its `worn.npz` for later jobs, into a folder.

    Args:
        dressed: The garment.
        folder: Folder, created if missing.

    Returns:
        The files: dressed.obj, .glb, .ply (with `strain` and `pressure` [Pa] at vertices), pattern.json, .svg and
            worn.npz.
    """
    folder.mkdir(parents=True, exist_ok=True)
    worn, garment = dressed.worn, dressed.worn.garment
    loads = {"strain": dressed.strain, "pressure": dressed.pressure}
    files = write_meshes(garment, garment.nodes, folder, "dressed", ("obj", "glb"))
    files.append(write_ply(garment.nodes, garment.faces, folder / "dressed.ply", loads))
    files.append(write_json(write_pattern(worn.pattern), folder / "pattern.json"))
    write_svg(worn.pattern, folder / "pattern.svg")
    return [*files, folder / "pattern.svg", save_worn(worn, folder)]
