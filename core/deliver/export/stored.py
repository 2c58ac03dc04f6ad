"""Read the meshes of a stored result from the files of its folder."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np

from ...reuse.wear.worn import ResultOld, WornGarment
from ..ply import PlyBad, read_ply
from .sewn_mesh import SewnMesh

RECOVERED_MESHES = ("graded", "detail", "simulation", "redrape")
"""Names of a recovery's meshes."""

REUSED_MESHES = ("dressed", "edited")
"""Names of the only mesh of a garment on another body, and of an edited one."""


def load_stored_meshes(folder: Path, worn: WornGarment, names: tuple[str, ...] = RECOVERED_MESHES) -> list[SewnMesh]:
    """Return the meshes of a stored result that exist, those of `REUSED_MESHES` among them.

    Args:
        folder: The result's files.
        worn: The result of `load_worn` there: topology, rest shape and fabric of all meshes.
        names: Some of `RECOVERED_MESHES`.

    Raises:
        ResultOld: where a mesh is not that garment's.
    """
    found = []
    for name in (*names, *REUSED_MESHES):
        path = folder / f"{name}.ply"
        if path.is_file():
            nodes = read_nodes(path)
            if nodes.shape != worn.garment.nodes.shape:
                raise ResultOld()
            found.append(SewnMesh(name, worn.garment, nodes, worn.fabric))
    return found


def read_nodes(path: Path) -> np.ndarray:
    """Read the positions of a PLY that `write_ply` wrote [m], shape [n, 3].

    Raises:
        ResultOld: where it is another one.
    """
    try:
        return read_ply(path.read_bytes()).vertices
    except PlyBad as error:
        raise ResultOld() from error


def garment_stem(folder: Path) -> str:
    """Return the stem of a result's file names: the scan's name, the pattern's, or `garment`, in plain letters."""
    named = ""
    for name, path in (("manifest.json", ("scan", "name")), ("pattern.json", ("properties", "name"))):
        try:
            value = json.loads((folder / name).read_text(encoding="utf-8"))
            for key in path:
                value = value[key]
            named = named or str(value)
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return re.sub(r"[^A-Za-z0-9-]+", "_", named)[:40].strip("_").lower() or "garment"
