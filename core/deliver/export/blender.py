"""Write a garment for Blender's cloth: panels cut along the seams, sewing threads, and a script that imports them."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np

from ...body.body import Body
from ...garment.orientation import place_points
from ...geometry.geometry import face_areas
from .sewn_mesh import SewnMesh, sanitise_names


def write_blender(mesh: SewnMesh, body: Body, folder: Path, stem: str) -> list[Path]:
    """Write `STEM_sewing.obj`, `STEM_worn.obj`, `STEM_body.obj` and `STEM_blender.py`, in metres, y up. The first has
    the flat panels in their rest placement, cut along the seams, with an edge (`l`) between each two vertices that a
    seam joins; the second the same mesh as worn, without those edges. Both have the same vertices in the same order, so
    that one is a shape key of the other."""
    garment = mesh.garment
    flat = np.zeros((len(garment.uv), 3))
    for index, panel in enumerate(garment.pattern.panels):
        in_panel = garment.panel_of_uv == index
        flat[in_panel] = place_points(panel, garment.uv[in_panel])
    worn = mesh.nodes[garment.uv_node]
    threads = sewing_threads(mesh)
    files_made = [folder / f"{stem}_{part}" for part in ("sewing.obj", "worn.obj", "body.obj", "blender.py")]
    files_made[0].write_text(_obj_text(mesh, flat, threads), encoding="utf-8")
    files_made[1].write_text(_obj_text(mesh, worn, threads[:0]), encoding="utf-8")
    lines = ["# metres, y up", "o body", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in body.vertices.tolist())]
    lines += [f"f {a} {b} {c}" for a, b, c in (body.faces + 1).tolist()]
    files_made[2].write_text("\n".join(lines) + "\n", encoding="utf-8")
    area = float(face_areas(np.pad(garment.uv, ((0, 0), (0, 1))), garment.uv_faces).sum())
    mass = mesh.fabric.density * area / len(garment.uv)
    program = files(__package__).joinpath("programs/blender.py").read_text(encoding="utf-8")
    program = program.replace('STEM = ""', f"STEM = {stem!r}").replace("VERTEX_MASS = 0.0", f"VERTEX_MASS = {mass:.9g}")
    files_made[3].write_text(program, encoding="utf-8")
    return files_made


def sewing_threads(mesh: SewnMesh) -> np.ndarray:
    """Return the pairs of uv vertices that seams join, each once, shape [n, 2]."""
    garment = mesh.garment
    pairs = [
        np.stack([garment.edge_uv[seam.a], garment.edge_uv[seam.b][:: -1 if seam.reversed else 1]], axis=1)
        for seam in garment.pattern.seams
    ]
    found = np.unique(np.sort(np.concatenate([*pairs, np.zeros((0, 2), np.int64)]), axis=1), axis=0)
    return np.asarray(found[found[:, 0] != found[:, 1]])


def _obj_text(mesh: SewnMesh, places: np.ndarray, threads: np.ndarray) -> str:
    """Return an OBJ of the panels cut along the seams, uv in metres, a group for each panel, threads as edges."""
    garment = mesh.garment
    lines = ["# metres, y up; 1 unit of uv is 1 m of cloth; l: sewing threads", "o garment"]
    lines += [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in places.tolist()]
    lines += [f"vt {u:.7f} {v:.7f}" for u, v in mesh.metre_uv.tolist()]
    for index, name in enumerate(sanitise_names([panel.name for panel in garment.pattern.panels])):
        lines.append(f"g {name}")
        panel_faces = garment.uv_faces[garment.panel_of_face == index] + 1
        lines += ["f " + " ".join(f"{v}/{v}" for v in face) for face in panel_faces.tolist()]
    lines += [f"l {a} {b}" for a, b in (threads + 1).tolist()]
    return "\n".join(lines) + "\n"
