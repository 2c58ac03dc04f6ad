"""Meshes and flat pattern of a result for the 3D view, as one compact binary: single precision, equal arrays once.

A container has the letters `GQV1`, the length of its head (uint32, little-endian), the head as JSON, and arrays. The
head refers to each array by [kind, place, count]: kind `f4`, `u1`, `u2` or `u4`, the place in bytes from the head's
end.
"""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from ...core.deliver.ply import PlyBad, PlyMesh, read_ply

MESHES = {
    "detail": "Detail",
    "simulation": "Simulation",
    "redrape": "Re-draped",
    "graded": "Graded",
    "dressed": "Dressed",
    "edited": "Edited",
    "under": "Worn below",
    "lower/dressed": "Lower",
    "one-piece/dressed": "One-piece",
    "upper/dressed": "Upper",
    "outer/dressed": "Outer",
    "garment": "Garment",
    "body": "Body",
    "scan": "Scan",
}
"""Titles of the meshes NAME.ply in the 3D view, in their order; others follow, titled by their file name. The first one
and the body are shown initially."""

UNDER = "under"
"""The garment worn below, which has a pattern of its own."""

WORN_TOGETHER = (UNDER, *(name for name in MESHES if "/" in name))
"""Meshes that are worn together and are all shown initially."""

BODY = "body"
"""Name of a wearer's mesh, and the beginning of the names of several: `body_SIZE` wears `draped_SIZE`."""

SCANS = ("scan",)
"""Large meshes, sent only on request."""

HIDDEN_MESHES = ("segmented",)
"""Copies of the scan that only the page of labels shows."""

WORN = "worn.npz"
"""File of the flat pattern."""

LETTERS = b"GQV1"

ARRAY_ALIGNMENT = 8
"""Alignment of arrays in a container [bytes]: a browser then reads them where they are."""

_FLAT = re.compile(
    r"garment\.((uv|uv_faces|uv_node|panel_of_uv)$|edge_uv\.\d+$|edges\.\d+\.|pattern\.seams\.\d+\.[ab]\."
    r"|pattern\.panels\.\d+\.(name|edges\.\d+\.(label|contour))$)"
)
"""Arrays of `worn.npz` from which the flat pattern is drawn."""


def list_shown(files: Collection[str]) -> dict[str, str]:
    """Return the titles of a result's meshes for the 3D view, by name, in their order."""
    there = sorted(name.removesuffix(".ply") for name in files if name.endswith(".ply"))
    further = {name: name.replace("_", " ").capitalize() for name in there if name not in (*MESHES, *HIDDEN_MESHES)}
    return {name: title for name, title in (MESHES | further).items() if name in there}


def is_companion_mesh(name: str) -> bool:
    """Return whether a mesh is not cloth of the result's pattern: a wearer, a scan, or the garment below."""
    return name in (*SCANS, UNDER) or name.startswith(BODY)


class Packer:
    """Collect arrays; equal ones are stored once."""

    def __init__(self) -> None:
        self.places: dict[bytes, int] = {}
        self.content = bytearray()

    def put(self, values: np.ndarray) -> list[Any]:
        """Add an array in the smallest kind that holds it, and return the head's reference to it."""
        values = np.ascontiguousarray(values)
        if values.dtype.kind == "f":
            kind = "f4"
        else:
            most = int(values.max(initial=0))
            kind = "u1" if values.dtype == np.uint8 else "u2" if most < 1 << 16 else "u4"
        content = values.astype(f"<{kind}").tobytes()
        key = kind.encode() + content
        if key not in self.places:
            self.content += bytes(-len(self.content) % ARRAY_ALIGNMENT)
            self.places[key] = len(self.content)
            self.content += content
        return [kind, self.places[key], values.size]

    def finish(self, head: Mapping[str, Any]) -> bytes:
        """Return the container."""
        text = json.dumps(head, separators=(",", ":")).encode()
        text += b" " * (-(len(text) + len(LETTERS) + 4) % ARRAY_ALIGNMENT)
        return LETTERS + len(text).to_bytes(4, "little") + text + bytes(self.content)


def pack_shown(meshes: Mapping[str, bytes], worn: bytes | None) -> bytes:
    """Return meshes and the flat pattern as one container.

    Args:
        meshes: PLY files of garmentq by the name of the mesh; unreadable ones are left out.
        worn: `worn.npz`, or None.
    """
    packer = Packer()
    found: dict[str, Any] = {}
    for name, content in meshes.items():
        try:
            found[name] = _put_mesh(packer, read_ply(content))
        except PlyBad:
            continue
    return packer.finish({"meshes": found, "flat": None if worn is None else _put_flat(packer, worn)})


def _put_mesh(packer: Packer, mesh: PlyMesh) -> dict[str, Any]:
    values = {name: packer.put(column) for name, column in mesh.values.items()}
    colours = None if mesh.colours is None else packer.put(mesh.colours)
    positions, faces = packer.put(mesh.vertices), packer.put(mesh.faces)
    return {"positions": positions, "faces": faces, "values": values, "colours": colours}


def _put_flat(packer: Packer, worn: bytes) -> dict[str, Any] | None:
    """Return the flat pattern; None if the file was stored by another version."""
    try:
        with zipfile.ZipFile(io.BytesIO(worn)) as archive:
            names = [name.removesuffix(".npy") for name in archive.namelist()]
            arrays = {name: _read(archive, name) for name in names if _FLAT.match(name)}
        return _describe(packer, arrays)
    except (KeyError, ValueError, OSError, EOFError, zipfile.BadZipFile):
        return None


def _read(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    with archive.open(f"{name}.npy") as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _describe(packer: Packer, arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    def text(name: str) -> str:
        value = arrays.get(f"garment.{name}")
        return "" if value is None else bytes(value).decode("utf-8", "replace")

    def number(name: str) -> int:
        return int(np.ravel(arrays[f"garment.{name}"])[0])

    def count(pattern: str) -> int:
        return sum(1 for name in arrays if re.fullmatch(pattern, name))

    panels = [text(f"pattern.panels.{n}.name") for n in range(count(r"garment\.pattern\.panels\.\d+\.name"))]
    edges = []
    for n in range(count(r"garment\.edge_uv\.\d+")):
        at, index = panels.index(text(f"edges.{n}.panel")), number(f"edges.{n}.edge")
        label = f"pattern.panels.{at}.edges.{index}"
        edges.append([at, index, text(f"{label}.label"), text(f"{label}.contour"),
                      packer.put(arrays[f"garment.edge_uv.{n}"])])  # fmt: skip
    seams = [
        [[panels.index(text(f"pattern.seams.{n}.{side}.panel")), number(f"pattern.seams.{n}.{side}.edge")]
         for side in "ab"]
        for n in range(count(r"garment\.pattern\.seams\.\d+\.a\.edge"))
    ]  # fmt: skip
    kept = {name: packer.put(arrays[f"garment.{name}"]) for name in ("uv", "uv_faces", "uv_node", "panel_of_uv")}
    return {"panels": panels, "edges": edges, "seams": seams, **kept}
