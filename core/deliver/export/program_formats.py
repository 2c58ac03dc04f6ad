"""Formats for other programs: meshes, sewn patterns, textures; each from a stored result's folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from ...run.errors import BadInput
from .blender import write_blender
from .clo import write_clo
from .sewn_files import write_sewn_glb, write_sewn_obj
from .sewn_mesh import SewnMesh
from .sewn_usd import write_sewn_usd
from .stored import garment_stem, load_stored_meshes
from .textured import write_textured

if TYPE_CHECKING:
    from ...scan.coloured import ColouredScan
    from ..formats.production import Production


class DetailMissing(BadInput):
    """A texture is made for the mesh that was deformed onto the scan; name the recovery, not a job made from it."""

    code = "export.detail_missing"


class ScanMissing(BadInput):
    """The scan of this result is no longer stored, so its colours are missing; submit the scan anew."""

    code = "export.scan_missing"


def write_obj(production: Production, folder: Path) -> list[Path]:
    """Write each of the result's meshes as OBJ with materials and a JSON of panels, seams and fabric."""
    stem = garment_stem(production.files)
    meshes = load_stored_meshes(production.files, production.worn)
    return [path for mesh in meshes for path in write_sewn_obj(mesh, folder / f"{stem}_{mesh.name}.obj")]


def write_glb(production: Production, folder: Path) -> list[Path]:
    """Write each of the result's meshes as GLB with panels, seams, flat rest shape and fabric."""
    stem = garment_stem(production.files)
    meshes = load_stored_meshes(production.files, production.worn)
    return [write_sewn_glb(mesh, folder / f"{stem}_{mesh.name}.glb") for mesh in meshes]


def write_usd(production: Production, folder: Path) -> list[Path]:
    """Write each of the result's meshes as USD with panels, seams, flat rest shape and fabric.

    Raises:
        UsdMissing: where the extra `usd` is not installed.
    """
    stem = garment_stem(production.files)
    meshes = load_stored_meshes(production.files, production.worn)
    return [write_sewn_usd(mesh, folder / f"{stem}_{mesh.name}.usd") for mesh in meshes]


def write_clo_files(production: Production, folder: Path) -> list[Path]:
    """Write the sewn pattern for CLO and Marvelous Designer.

    Raises:
        SeamUnsewable: where a seam cannot be written for them.
    """
    worn = production.worn
    return write_clo(worn.pattern, worn.fabric, folder, garment_stem(production.files))


def write_blender_files(production: Production, folder: Path) -> list[Path]:
    """Write panels with sewing threads for Blender, worn as in the result."""
    worn = production.worn
    mesh = SewnMesh("worn", worn.garment, worn.garment.nodes, worn.fabric)
    return write_blender(mesh, worn.body, folder, garment_stem(production.files))


def write_texture(production: Production, folder: Path) -> list[Path]:
    """Write the detail mesh with the colours of its scan, the texture, and prints of the pieces.

    Raises:
        DetailMissing: where the result has no detail mesh.
        ScanMissing: where the scan's file is not there.
        ColoursMissing: where the scan has no colours.
    """
    meshes = load_stored_meshes(production.files, production.worn, ("detail",))
    if not meshes or meshes[0].name != "detail":
        raise DetailMissing()
    if production.scan is None or not production.scan.is_file():
        raise ScanMissing()
    scan = read_colours(production.scan, production.files)
    stem = garment_stem(production.files)
    return write_textured(meshes[0], scan, folder, stem, production.options.texel).files


def read_colours(scan: Path, result: Path) -> ColouredScan:
    """Read the colours of a result's scan: its file, or the reading of a garment that was cut out of a person's scan.

    Args:
        scan: The file.
        result: Folder of the result, whose manifest has the unit and axes of the file.

    Raises:
        ColoursMissing: where it has none.
        ScanMissing: where the manifest lacks unit or axes.
    """
    from ...garment.reading import load_reading
    from ...scan.coloured import load_coloured, to_coloured_scan

    if scan.suffix == ".npz":
        return to_coloured_scan(load_reading(scan).pieces.garment, is_cut=True)
    try:
        description = json.loads((result / "manifest.json").read_text(encoding="utf-8"))["scan"]
        units, up = str(description["units"]), str(description["up"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ScanMissing() from error
    return load_coloured(scan, units, up)
