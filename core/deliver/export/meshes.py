"""Write meshes as PLY, OBJ and GLB."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...garment.garment import Garment
from ...garment.pieces.shelf_packing import pack_on_shelves
from ...geometry.geometry import vertex_normals
from .glb import GL_ARRAY_BUFFER, GL_ELEMENT_ARRAY_BUFFER, GlbBuffer, describe_scene, make_material, pack_glb

UV_GAP = 0.02
"""Space between panels in the uv plane [m]: a texture may bleed 2 cm over an edge before it meets another panel."""

UV_WIDTH = 1.5
"""Width of the uv plane [m]: that of most cloth, so that the layout reads like a marker."""

KINDS = ("ply", "obj", "glb")

CLOTH_LOOK = {"baseColorFactor": [0.59, 0.67, 0.75, 1.0]}
"""Colour of cloth without a texture in a GLB: red, green, blue and opacity, linear, of 1."""


def uv_layout(garment: Garment) -> np.ndarray:
    """Return texture coordinates in metres of cloth, shape [uv_count, 2]; 1 unit of u or v is 1 m. Panels are side by
    side in their own axes, unscaled: islands do not overlap, and a texture of 10 cm of cloth repeats ten times per
    unit."""
    uv = np.array(garment.uv, dtype=np.float64)
    panels = np.unique(garment.panel_of_uv)
    members = [garment.panel_of_uv == panel for panel in panels]
    low = np.array([uv[mask].min(axis=0) for mask in members])
    sizes = np.array([uv[mask].max(axis=0) for mask in members]) - low
    for mask, corner, place in zip(members, low, pack_on_shelves(sizes, UV_GAP, UV_WIDTH), strict=True):
        uv[mask] += place - corner
    return uv


def write_meshes(
    garment: Garment, nodes: np.ndarray, folder: Path, stem: str, kinds: tuple[str, ...] = KINDS
) -> list[Path]:
    """Write one state of a garment in several formats, in metres, y up.

    PLY is the welded mesh for simulators. OBJ is welded too, with a uv for each corner and a group per panel. GLB is
    split along the seams, as its format requires. Uv are those of `uv_layout`; a glTF's v runs downwards, so GLB has 1
    - v.

    Args:
        garment: Topology, uv and panels.
        nodes: Positions [m], shape [node_count, 3].
        folder: Folder of the files, which exists.
        stem: Name of the files before the dot.
        kinds: Some of `KINDS`.

    Returns:
        The files written, in the order of `kinds`.
    """
    written = []
    for kind in kinds:
        path = folder / f"{stem}.{kind}"
        if kind == "ply":
            write_ply(nodes, garment.faces, path)
        elif kind == "obj":
            path.write_text(_obj_text(garment, nodes), encoding="utf-8")
        else:
            path.write_bytes(_glb_bytes(garment, nodes, stem))
        written.append(path)
    return written


def write_ply(
    vertices: np.ndarray,
    faces: np.ndarray,
    path: Path,
    values: Mapping[str, np.ndarray] | None = None,
    colours: np.ndarray | None = None,
) -> Path:
    """Write a welded triangle mesh as binary PLY [m]: double positions, nothing merged or reordered.

    Args:
        vertices: Positions [m], shape [n, 3].
        faces: Vertex indices, shape [m, 3]; of a cloud none.
        path: The file.
        values: Further numbers of each vertex by the name of their property, shape [n] each.
        colours: RGB bytes of each vertex, shape [n, 3], or None.
    """
    values = {"x": vertices[:, 0], "y": vertices[:, 1], "z": vertices[:, 2]} | dict(values or {})
    shades = {} if colours is None else dict(zip(("red", "green", "blue"), colours.T, strict=True))
    table = np.zeros(len(vertices), dtype=[(name, "<f8") for name in values] + [(name, "u1") for name in shades])
    for name, column in (values | shades).items():
        table[name] = column
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment metres, y up\n"
        f"element vertex {len(vertices)}\n"
        + "".join(f"property double {name}\n" for name in values)
        + "".join(f"property uchar {name}\n" for name in shades)
        + f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    rows["count"], rows["corners"] = 3, faces
    path.write_bytes(header.encode("ascii") + table.tobytes() + rows.tobytes())
    return path


def _obj_text(garment: Garment, nodes: np.ndarray) -> str:
    """Return a Wavefront OBJ: welded positions and normals, uv of each corner, one group per panel."""
    lines = ["# metres, y up; 1 unit of uv is 1 m of cloth"]
    lines += [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in nodes.tolist()]
    lines += [f"vt {u:.7f} {v:.7f}" for u, v in uv_layout(garment).tolist()]
    lines += [f"vn {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertex_normals(nodes, garment.faces).tolist()]
    for index, panel in enumerate(garment.pattern.panels):
        ids = np.flatnonzero(garment.panel_of_face == index)
        # Panel names are the file author's: only plain characters are written to the OBJ.
        lines.append("g " + (re.sub(r"[^A-Za-z0-9_.-]+", "_", panel.name) or f"panel_{index}"))
        for corners, flat in zip((garment.faces[ids] + 1).tolist(), (garment.uv_faces[ids] + 1).tolist(), strict=True):
            lines.append("f " + " ".join(f"{v}/{t}/{v}" for v, t in zip(corners, flat, strict=True)))
    return "\n".join(lines) + "\n"


def _glb_bytes(garment: Garment, nodes: np.ndarray, name: str) -> bytes:
    """Return a binary glTF of one mesh, split along the seams."""
    buffer = GlbBuffer()
    scene = describe_scene(name, [add_split_mesh(garment, nodes, buffer)], [make_material("cloth", CLOTH_LOOK)])
    return pack_glb(scene, buffer)


def add_split_mesh(garment: Garment, nodes: np.ndarray, buffer: GlbBuffer) -> dict[str, Any]:
    """Add a mesh that is split along the seams, nodes [m], shape [node_count, 3], to a buffer; return its primitive."""
    flat = uv_layout(garment)
    flat[:, 1] = 1.0 - flat[:, 1]  # a glTF's v runs downwards
    split, normals = garment.uv_node, vertex_normals(nodes, garment.faces)
    values = {"POSITION": nodes[split], "NORMAL": normals[split], "TEXCOORD_0": flat}
    attributes = {
        key: buffer.add(array.astype("<f4"), GL_ARRAY_BUFFER, bounds=key == "POSITION") for key, array in values.items()
    }
    corners = buffer.add(garment.uv_faces.astype("<u4").ravel(), GL_ELEMENT_ARRAY_BUFFER)
    return {"attributes": attributes, "indices": corners, "material": 0}
