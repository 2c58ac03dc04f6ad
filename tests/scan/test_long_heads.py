"""Legal files in which what a reader looks for comes late: behind long comments, names, or other lines."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.scan.coloured import load_coloured
from garmentq.core.scan.limits import Limits
from garmentq.core.scan.load import load_scan
from garmentq.core.scan.load_raw import load_raw
from garmentq.core.scan.parse import parse
from PIL import Image

INSIDE = Limits(is_confined=True)
"""Parsing here: a process for each file would take most of the time."""
BODY = builtin_body("builtin:female,height=1.70")
V, F = BODY.vertices, BODY.faces
LONG = 200_000
"""Bytes before what is looked for, three times of what is read at first."""
ROWS = "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in V)
TALK = "# scanner's log: all was well\n" * (LONG // 30)


def write_obj(path: Path) -> None:
    """Write texture coordinates and normals first, as other programs do."""
    lines = [f"vt {u:.6f} {v:.6f}\n" for u, v in V[:, :2]] + [f"vn {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in V]
    lines += [f"v {row}\n" for row in ROWS.splitlines()]
    lines += [f"f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}\n" for a, b, c in F + 1]
    assert len("".join(lines[: 2 * len(V)])) > LONG
    path.write_text("".join(lines))


def write_off(path: Path) -> None:
    """Write a log between the first word and the counts."""
    path.write_text(f"OFF\n{TALK}{len(V)} {len(F)} 0\n{ROWS}" + "".join(f"3 {a} {b} {c}\n" for a, b, c in F))


def write_stl(path: Path) -> None:
    """Write an ASCII STL with a long name at both ends."""
    text = trimesh.Trimesh(V, F, process=False).export(file_type="stl_ascii")
    body = text.split("\n", 1)[1].rsplit("endsolid", 1)[0]
    path.write_text(f"solid {'x' * LONG}\n{body}endsolid {'x' * LONG}\n")


def write_ply(path: Path, comment: str = "comment all was well\n") -> None:
    """Write a PLY with a long log in its header."""
    content = trimesh.Trimesh(V, F, process=False).export(file_type="ply")
    log = (comment * (LONG // len(comment))).encode()
    path.write_bytes(content.replace(b"element vertex", log + b"element vertex"))


def write_information(path: Path) -> None:
    """Write a PLY with long `obj_info`."""
    write_ply(path, "obj_info a matrix of each of many frames\n")


WRITERS = {"vt.obj": write_obj, "log.off": write_off, "name.stl": write_stl, "log.ply": write_ply,
           "info.ply": write_information}  # fmt: skip


@pytest.mark.parametrize("name", WRITERS)
def test_a_mesh_is_read_however_late_it_begins(tmp_path, name):
    """Broken where only the first bytes of a file are looked at for what may come later."""
    path = tmp_path / name
    WRITERS[name](path)
    scan = load_scan(path, kind="body", limits=INSIDE)
    assert len(scan.faces) == len(F) and len(scan.vertices) == len(V)
    assert np.ptp(scan.vertices, axis=0) == pytest.approx(np.ptp(V, axis=0), abs=1e-5)
    raw = load_raw(path, limits=INSIDE)
    assert len(raw.faces) == len(F) and raw.units == "m"


@pytest.mark.parametrize("name", ["xyz", "pcd"])
def test_a_cloud_is_read_however_late_it_begins(tmp_path, name):
    """Broken where a cloud's log makes it be refused."""
    path = tmp_path / f"p.{name}"
    head = f"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {len(V)}\nHEIGHT 1\nDATA ascii\n"
    path.write_text(TALK + (head if name == "pcd" else "") + ROWS)
    raw = load_raw(path, "m", "y", INSIDE)
    kept = raw.place >= 0
    assert len(kept) == len(V) and kept.mean() > 0.75
    assert np.allclose(raw.points[raw.place[kept]], V[kept], atol=1e-5)


def test_a_texture_is_found_behind_a_log(tmp_path):
    """Broken where a PLY's image is not read since it is named late in the header."""
    Image.new("RGB", (4, 4), (250, 20, 20)).save(tmp_path / "skin.png")
    mesh = trimesh.Trimesh(V, F, process=False, visual=trimesh.visual.TextureVisuals(uv=V[:, :2] % 1.0))
    content = mesh.export(file_type="ply")
    log = b"comment all was well\n" * (LONG // 20) + b"comment TextureFile skin.png\n"
    (tmp_path / "p.ply").write_bytes(content.replace(b"element vertex", log + b"element vertex", 1))
    assert (parse(tmp_path / "p.ply", "ply", textures=True)["colours"] == [250, 20, 20]).all()


def embed(glb: bytes) -> bytes:
    """Return a GLB as a .gltf that holds its buffer itself."""
    (length,) = struct.unpack_from("<I", glb, 12)
    tree = json.loads(glb[20 : 20 + length])
    data = base64.b64encode(glb[28 + length :]).decode()
    tree["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
    return json.dumps(tree).encode()


def test_a_gltf_that_holds_its_data_is_read(tmp_path):
    """Broken where a .gltf of one file is refused or read otherwise than the same GLB, its image too."""
    image = Image.new("RGB", (4, 4), (250, 20, 20))
    image.paste((20, 20, 250), (0, 0, 2, 4))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=image)
    uv = V[:, :2] % 1.0
    mesh = trimesh.Trimesh(V, F, process=False, visual=trimesh.visual.TextureVisuals(uv=uv, material=material))
    content = mesh.export(file_type="glb")
    (tmp_path / "p.glb").write_bytes(content)
    (tmp_path / "p.gltf").write_bytes(embed(content))
    binary, text = (load_raw(tmp_path / name, limits=INSIDE) for name in ("p.glb", "p.gltf"))
    assert np.array_equal(binary.points, text.points) and np.array_equal(binary.faces, text.faces)
    assert text.up_axis == "y" and np.array_equal(binary.colours, text.colours)
    seen = np.clip(np.round(255 * text.colours), 0, 255)
    assert (seen[:, 1] == 20).all() and set(np.unique(seen[:, 0])) >= {20, 250}
    assert len(load_scan(tmp_path / "p.gltf", kind="body").faces) == len(F)
    (picture,) = load_coloured(tmp_path / "p.gltf", "m", "y").images
    assert (picture[:, 2:] == [250, 20, 20]).all() and (picture[:, :2] == [20, 20, 250]).all()
