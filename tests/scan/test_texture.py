"""Colours come out of textures, and a texture that cannot be had is told and costs nothing."""

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.scan.limits import Limits
from garmentq.core.scan.load_raw import load_raw
from garmentq.core.scan.texture import TextureBad, open_image, sample_image
from PIL import Image

INSIDE = Limits(is_confined=True)
BODY = builtin_body("builtin:female,height=1.70")
V, F = BODY.vertices, BODY.faces
LOW, SIZE = V.min(axis=0), np.ptp(V, axis=0)
UV = ((V - LOW) / SIZE)[:, :2]


def draw():
    """Return an image that is red by x from left to right and green by y from the lower end up."""
    x, y = np.meshgrid(np.arange(256), np.arange(255, -1, -1))
    return Image.fromarray(np.stack([x, y, np.full_like(x, 77)], axis=-1).astype(np.uint8))


def check(raw):
    """Check that each point has the colour of its place."""
    where = (raw.points - LOW) / SIZE
    assert raw.colours is not None
    assert np.abs(raw.colours[:, :2] - where[:, :2]).max() < 0.03
    assert np.allclose(raw.colours[:, 2], 77 / 255, atol=0.02)


def test_sampling_meets_pixel_centres():
    """Broken where v runs down, samples are half a pixel off, or coordinates beyond the image are not repeated."""
    image = np.arange(12, dtype=np.uint8).reshape(2, 2, 3)
    uv = np.array([[0.25, 0.75], [0.75, 0.75], [0.25, 0.25], [0.5, 0.75], [1.25, -0.25], [0.0, 1.0]])
    assert np.allclose(sample_image(image, uv)[:, 0], [0, 3, 6, 1.5, 0, 0])


def test_an_obj_with_its_material(tmp_path):
    """Broken where the corners' coordinates go to the wrong vertices, or the material's options to the name."""
    draw().save(tmp_path / "skin one.png")
    (tmp_path / "p.mtl").write_text("newmtl other\nKd 1 0 0\nnewmtl m\nKd 1 1 1\nmap_Kd -s 1 1 1 skin one.png\n")
    lines = ["mtllib p.mtl", "usemtl m", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in V)]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in UV[::-1]]
    lines += ["f " + " ".join(f"{i + 1}/{len(V) - i}" for i in face) for face in F]
    (tmp_path / "p.obj").write_text("\n".join(lines) + "\n")
    check(load_raw(tmp_path / "p.obj", limits=INSIDE))


@pytest.mark.parametrize("lost", ["p.mtl", "skin.png"])
def test_a_texture_that_is_not_there_is_told(tmp_path, lost):
    """Broken where a scan is refused, or its colours are missing without a word, for a file that did not come along."""
    draw().save(tmp_path / "skin.png")
    (tmp_path / "p.mtl").write_text("newmtl m\nmap_Kd skin.png\n")
    lines = ["mtllib p.mtl", "usemtl m", *(f"v {x:.6f} {y:.6f} {z:.6f}\nvt 0.5 0.5" for x, y, z in V)]
    lines += ["f " + " ".join(f"{i + 1}/{i + 1}" for i in face) for face in F]
    (tmp_path / "p.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / lost).unlink()
    raw = load_raw(tmp_path / "p.obj", limits=INSIDE)
    assert raw.colours is None and any(lost in note and "GLB" in note for note in raw.notes)


@pytest.mark.parametrize("name", ["../secret.png", "/etc/passwd", "\\\\host\\share\\x.png"])
def test_a_texture_elsewhere_is_not_read(tmp_path, name):
    """Broken where a scan's file makes the program read outside its folder."""
    folder = tmp_path / "in"
    folder.mkdir()
    draw().save(tmp_path / "secret.png")
    (folder / "p.mtl").write_text(f"newmtl m\nmap_Kd {name}\n")
    lines = ["mtllib p.mtl", "usemtl m", *(f"v {x:.6f} {y:.6f} {z:.6f}\nvt 0.5 0.5" for x, y, z in V)]
    lines += ["f " + " ".join(f"{i + 1}/{i + 1}" for i in face) for face in F]
    (folder / "p.obj").write_text("\n".join(lines) + "\n")
    raw = load_raw(folder / "p.obj", limits=INSIDE)
    assert raw.colours is None and any("not beside the scan" in note for note in raw.notes)


def test_a_glb_with_its_image(tmp_path):
    """Broken where glTF's coordinates, which run down, are not turned, or seams lose a vertex."""
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=draw())
    look = trimesh.visual.TextureVisuals(uv=UV, material=material)
    trimesh.Trimesh(V, F, visual=look, process=False).export(tmp_path / "p.glb")
    raw = load_raw(tmp_path / "p.glb")
    assert len(raw.points) == len(V)
    check(raw)


def test_a_ply_with_its_texture_file(tmp_path):
    """Broken where MeshLab's comment and the coordinates of the vertices are not read."""
    draw().save(tmp_path / "t.jpg", quality=95)
    head = f"ply\nformat ascii 1.0\ncomment TextureFile t.jpg\nelement vertex {len(V)}\n"
    head += "".join(f"property float {axis}\n" for axis in ("x", "y", "z", "s", "t"))
    head += f"element face {len(F)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [f"{x:.6f} {y:.6f} {z:.6f} {u:.6f} {v:.6f}" for (x, y, z), (u, v) in zip(V, UV, strict=True)]
    (tmp_path / "p.ply").write_text(head + "\n".join([*rows, *(f"3 {a} {b} {c}" for a, b, c in F)]) + "\n")
    check(load_raw(tmp_path / "p.ply", limits=INSIDE))


def test_a_large_image_is_not_decoded(tmp_path):
    """Broken where the size of an image is known only once its pixels fill the memory."""
    import struct
    import zlib

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 40000, 40000, 8, 2, 0, 0, 0)
    path = tmp_path / "bomb.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b""))
    with pytest.raises(TextureBad, match=r"40000 x 40000|no image"):
        open_image(path, "bomb.png")
    (tmp_path / "text.png").write_text("hello")
    with pytest.raises(TextureBad, match="no image"):
        open_image(path, "text.png")
