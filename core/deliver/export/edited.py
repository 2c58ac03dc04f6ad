"""Write a version of a result into one folder."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from ...garment.garmentcode_writer import write_pattern
from ...reuse.edit.redraping import EditedGarment
from ...reuse.wear.worn import save_worn
from .edited_report import draw_versions, report_edited
from .meshes import write_meshes, write_ply
from .pattern_svg import write_svg
from .result import write_body, write_json


def write_edited(edited: EditedGarment, folder: Path) -> list[Path]:
    """Write meshes, pattern, difference, numbers and report of an edited garment.

    Args:
        edited: The garment.
        folder: Folder, created if missing; files of the same names are replaced.

    Returns:
        The files: edited.obj, .glb, .ply (with `strain` and `pressure` [Pa] of each vertex), body.ply,
            body_joints.json, pattern.json, pattern.svg, difference.json, metrics.json, manifest.json, worn.npz,
            picture.png, report.html.
    """
    folder.mkdir(parents=True, exist_ok=True)
    worn = edited.worn
    garment, loads = worn.garment, {"strain": edited.strain, "pressure": edited.pressure}
    files = write_meshes(garment, garment.nodes, folder, "edited", ("obj", "glb"))
    files.append(write_ply(garment.nodes, garment.faces, folder / "edited.ply", loads))
    files += write_body(worn.body, folder)
    files.append(write_json(write_pattern(worn.pattern), folder / "pattern.json"))
    write_svg(worn.pattern, folder / "pattern.svg")
    files.append(folder / "pattern.svg")
    files.append(write_json(asdict(edited.difference), folder / "difference.json"))
    files.append(write_json(edited.report.metrics, folder / "metrics.json"))
    files.append(write_json(edited.report.manifest, folder / "manifest.json"))
    files.append(save_worn(worn, folder))
    picture, report = folder / "picture.png", folder / "report.html"
    picture.write_bytes(draw_versions(edited))
    report.write_text(report_edited(edited, picture.read_bytes()), encoding="utf-8")
    return [*files, picture, report]
