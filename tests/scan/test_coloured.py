"""Colours of a scan's file at places of its faces: of vertices, of an OBJ's and a GLB's images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.run.errors import BadInput
from garmentq.core.run.sandbox import ReaderCrashed
from garmentq.core.scan.coloured import ColouredScan, ColoursMissing, _check, load_coloured
from garmentq.core.scan.limits import Limits
from PIL import Image

INSIDE = Limits(is_confined=True)
BALL = trimesh.creation.icosphere(subdivisions=3, radius=0.4)
FLAT = (BALL.vertices[:, :2] + 0.4) / 0.8


def draw() -> Image.Image:
    """Return an image that is red by x from left to right and green by y from the lower end up."""
    x, y = np.meshgrid(np.arange(256), np.arange(255, -1, -1))
    return Image.fromarray(np.stack([x, y, np.full_like(x, 77)], axis=-1).astype(np.uint8))


def write_obj(folder: Path, flat: np.ndarray = FLAT) -> Path:
    """Write a ball with an image as OBJ, faces as quads where two triangles are one after the other."""
    draw().save(folder / "skin.png")
    (folder / "p.mtl").write_text("newmtl m\nmap_Kd skin.png\n")
    lines = ["mtllib p.mtl", "usemtl m", *(f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in BALL.vertices)]
    lines += [f"vt {u:.7f} {v:.7f}" for u, v in flat[::-1]]
    lines += ["f " + " ".join(f"{i + 1}/{len(flat) - i}" for i in face) for face in BALL.faces]
    (folder / "p.obj").write_text("\n".join(lines) + "\n")
    return folder / "p.obj"


def write_glb(folder: Path) -> Path:
    """Write a ball with an image as GLB."""
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=draw())
    look = trimesh.visual.TextureVisuals(uv=FLAT, material=material)
    trimesh.Trimesh(BALL.vertices, BALL.faces, visual=look, process=False).export(folder / "p.glb")
    return folder / "p.glb"


def check_places(scan: ColouredScan) -> None:
    """Check that places of faces have the colours of their positions."""
    rng = np.random.default_rng(0)
    face = rng.integers(len(scan.faces), size=500)
    weights = rng.dirichlet(np.ones(3), size=500)
    places = np.einsum("nk,nkd->nd", weights, scan.vertices[scan.faces[face]])
    found = scan.colours_at(face, weights)
    assert np.abs(found[:, :2] / 255.0 - (places[:, :2] + 0.4) / 0.8).max() < 0.01
    assert np.abs(found[:, 2] - 77.0).max() < 1.0


@pytest.mark.parametrize("write", [write_obj, write_glb])
def test_images_are_read_at_each_place(write, tmp_path: Path) -> None:
    """Fails if a corner took another corner's coordinates, or v runs down."""
    check_places(load_coloured(write(tmp_path), "m", "y", INSIDE))


def test_polygons_keep_their_coordinates(tmp_path: Path) -> None:
    """Fails if corners of a polygon, of any size and counted from either end, get another corner's coordinates."""
    draw().save(tmp_path / "skin.png")
    (tmp_path / "p.mtl").write_text("newmtl m\nmap_Kd skin.png\n")
    places = [(0, 0), (0.3, 0), (0.4, 0.2), (0.3, 0.4), (0, 0.4), (-0.4, 0.4), (-0.4, 0)]
    lines = ["mtllib p.mtl", "usemtl m", *(f"v {x} {y} {x + y}" for x, y in places)]
    lines += [f"vt {(x + 0.4) / 0.8} {(y + 0.4) / 0.8}" for x, y in places[::-1]]
    lines += ["f 1/7 2/6 3/5 4/4 5/3", "f -7/-1 -3/-5 -2/-6 -1/-7"]
    (tmp_path / "p.obj").write_text("\n".join(lines) + "\n")
    found = load_coloured(tmp_path / "p.obj", "m", "y", INSIDE)
    assert np.array_equal(found.faces, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6]])
    check_places(found)


def test_a_limited_process_reads_the_same(tmp_path: Path) -> None:
    """Fails if what is handed over lost an image."""
    path = write_glb(tmp_path)
    check_places(load_coloured(path, "m", "y"))


def test_units_and_axis_are_the_recovery_s(tmp_path: Path) -> None:
    """Fails if colours would lie beside the garment."""
    found = load_coloured(write_obj(tmp_path), "cm", "z", INSIDE)
    assert found.vertices == pytest.approx(0.01 * BALL.vertices[:, [0, 2, 1]] * [1, 1, -1], abs=1e-8)


def test_colours_of_vertices_are_interpolated(tmp_path: Path) -> None:
    """Fails if a PLY's colours went to other vertices."""
    colours = np.column_stack([FLAT * 255.0, np.full(len(FLAT), 77.0)])
    mesh = trimesh.Trimesh(BALL.vertices, BALL.faces, vertex_colors=np.round(colours).astype(np.uint8), process=False)
    mesh.export(tmp_path / "p.ply")
    check_places(load_coloured(tmp_path / "p.ply", "m", "y", INSIDE))


def test_a_scan_without_colours_is_refused_with_the_reason(tmp_path: Path) -> None:
    """Fails if a grey texture is made of nothing, or the lost image is not named."""
    trimesh.Trimesh(BALL.vertices, BALL.faces, process=False).export(tmp_path / "p.ply")
    with pytest.raises(ColoursMissing) as caught:
        load_coloured(tmp_path / "p.ply", "m", "y", INSIDE)
    assert caught.value.code == "scan.colours_missing"
    path = write_obj(tmp_path)
    (tmp_path / "skin.png").unlink()
    with pytest.raises(ColoursMissing, match=r"skin\.png"):
        load_coloured(path, "m", "y", INSIDE)


def test_coordinates_that_are_not_there_are_refused(tmp_path: Path) -> None:
    """Fails if a face's coordinate beyond the last one is a traceback."""
    path = write_obj(tmp_path)
    path.write_text(path.read_text().replace("/7 ", "/99999 "))
    with pytest.raises(BadInput):
        load_coloured(path, "m", "y", INSIDE)


def test_what_a_process_hands_over_is_looked_at() -> None:
    """Fails if an index beyond the vertices, or an image of another shape, is believed."""
    good = ColouredScan(
        BALL.vertices,
        BALL.faces,
        None,
        np.zeros((len(BALL.faces), 3, 2)),
        np.zeros(len(BALL.faces), int),
        (np.zeros((2, 2, 3), np.uint8),),
    )
    _check(good)
    for wrong in (
        {"faces": BALL.faces + 1}, {"image": good.image + 1}, {"images": (np.zeros((2, 2), np.uint8),)},
        {"colours": np.zeros((3, 3))},
    ):  # fmt: skip
        with pytest.raises(ReaderCrashed):
            _check(ColouredScan(**{**good.__dict__, **wrong}))
