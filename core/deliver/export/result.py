"""Write the result of a recovery into one folder."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ...body.body import JOINT_PARENTS, JOINTS, Body
from ...garment.garmentcode_writer import write_pattern
from ...recover.recovery import Recovery
from ...reuse.wear.worn import save_worn, worn_from_recovery
from ...scan.coloured import to_coloured_scan
from ..formats.production import FIT_FILE_NAME
from ..texture.lookup import colour_vertices
from .meshes import write_meshes, write_ply
from .pattern_svg import write_svg
from .report import report_html


def write_recovery(recovery: Recovery, folder: Path) -> list[Path]:
    """Write meshes, pattern, numbers and report of a recovery.

    Args:
        recovery: The result.
        folder: Folder, created if missing; files of the same names are replaced.

    Returns:
        The files: graded.ply, detail.ply, detail.obj, detail.glb, simulation.ply and redrape.ply (if the method makes
            them; each .ply with the `distance` [m] of each vertex from the scan, and 1 as `inferred` where that does
            not show it), scan.ply (as it was read), body.ply, body_joints.json, pattern.json, pattern.svg, fit.json
            (likewise), metrics.json, manifest.json, worn.npz, report.html. Of a scan with colours scan.ply has them,
            and detail.ply the scan's colour at each vertex.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files: list[Path] = []
    coloured = (
        None if recovery.scan.colours is None else to_coloured_scan(recovery.scan, recovery.scan.unseen is not None)
    )
    for name, nodes in recovery.meshes:
        faces, apart = recovery.garment.faces, {"distance": recovery.scan.surface.distance(nodes)}
        apart["inferred"] = recovery.inferred_nodes.astype(float)
        shades = colour_vertices(nodes, faces, coloured) if coloured and name == "detail" else None
        files.append(write_ply(nodes, faces, folder / f"{name}.ply", apart, shades))
        files += write_meshes(recovery.garment, nodes, folder, name, ("obj", "glb")) if name == "detail" else []
    shades = None if coloured is None else coloured.colours
    files.append(write_ply(recovery.scan.vertices, recovery.scan.faces, folder / "scan.ply", colours=shades))
    files += write_body(recovery.body, folder)
    files.append(write_json(write_pattern(recovery.pattern), folder / "pattern.json"))
    write_svg(recovery.pattern, folder / "pattern.svg")
    files.append(folder / "pattern.svg")
    if recovery.estimates:
        files.append(write_json(describe_fit(recovery), folder / FIT_FILE_NAME))
    files.append(write_json(recovery.report.metrics, folder / "metrics.json"))
    files.append(write_json(recovery.report.manifest, folder / "manifest.json"))
    files.append(save_worn(worn_from_recovery(recovery), folder))
    report = folder / "report.html"
    report.write_text(report_html(recovery), encoding="utf-8")
    return [*files, report]


def describe_fit(recovery: Recovery) -> dict[str, Any]:
    """Return the fit's estimates of the fabric and of each control point [m], as plain JSON values."""
    found: dict[str, Any] = {
        "fabric": {
            each.name: {
                "value": each.value,
                "std": each.std,
                "prior_std": each.prior_std,
                "identifiable": each.identifiable,
                "note": each.note,
            }
            for each in recovery.estimates
        },
        "nearest_fabrics": list(recovery.nearest_fabrics),
        "std_is_of": "the natural logarithm",
    }
    if recovery.point_std is not None:
        starts = recovery.pattern.point_starts
        found["control_point_std_m"] = {
            panel.name: recovery.point_std[int(starts[n]) : int(starts[n]) + len(panel.points)].tolist()
            for n, panel in enumerate(recovery.pattern.panels)
        }
    return found


def to_plain_json(value: Any) -> Any:
    """Convert a value to plain JSON: arrays to lists, nan and inf to null, the rest to text."""
    if isinstance(value, dict):
        return {str(key): to_plain_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain_json(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return to_plain_json(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def write_json(value: Any, path: Path) -> Path:
    """Write a value as `to_plain_json` JSON, and return the file."""
    path.write_text(
        json.dumps(to_plain_json(value), indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8"
    )
    return path


def write_body(body: Body, folder: Path) -> list[Path]:
    """Write a body's mesh, body.ply, and its joints, body_joints.json, into a folder; return both files."""
    mesh = write_ply(body.vertices, body.faces, folder / "body.ply")
    return [mesh, write_json(describe_joints(body), folder / "body_joints.json")]


def describe_joints(body: Body) -> dict[str, Any]:
    """Return the joints by name with their parents [m]."""
    return {
        "unit": "m",
        "source": body.source,
        "joints": {
            name: {"position": position.tolist(), "parent": JOINTS[parent] if parent >= 0 else None}
            for name, position, parent in zip(JOINTS, body.joints, JOINT_PARENTS, strict=True)
        },
    }
