"""Meshes on disk, read back by another library."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.deliver.export.meshes import uv_layout, write_meshes
from garmentq.core.garment.pieces.shelf_packing import pack_on_shelves


@pytest.fixture(scope="module")
def garment(tube, tube_pattern):
    """Return a rolled tube whose second panel has a name that no OBJ may hold."""
    return tube(tube_pattern(names=("front", "back\nf 1 1 1")))


def flat_areas(uv: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the signed areas of flat triangles."""
    a, b, c = (uv[faces[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def read(path: Path) -> trimesh.Trimesh:
    """Read a mesh as it is."""
    mesh = trimesh.load(path, process=False, force="mesh")
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


def test_ply_is_the_welded_mesh(garment, tmp_path: Path) -> None:
    """Fails if PLY were split along seams, reordered or rounded."""
    (path,) = write_meshes(garment, garment.nodes, tmp_path, "detail", ("ply",))
    mesh = read(path)
    assert np.array_equal(mesh.vertices, garment.nodes)
    assert np.array_equal(mesh.faces, garment.faces)


@pytest.mark.parametrize("kind", ["obj", "glb"])
def test_obj_and_glb_carry_the_pattern_as_uv(kind: str, garment, tmp_path: Path) -> None:
    """Fails if uv lost its scale or its corner: every face's uv triangle is its flat piece of cloth, in metres."""
    (path,) = write_meshes(garment, garment.nodes, tmp_path, "detail", (kind,))
    mesh = read(path)
    assert len(mesh.vertices) == len(garment.uv) > len(garment.nodes)
    assert len(mesh.faces) == len(garment.faces)
    # Readers may order faces by group; a face is known by the place of its centre.
    mine = garment.nodes[garment.faces].mean(axis=1)
    order = [int(np.argmin(np.linalg.norm(mine - centre, axis=1))) for centre in mesh.triangles_center]
    assert sorted(order) == list(range(len(garment.faces)))
    assert mesh.triangles_center == pytest.approx(mine[order], abs=1e-6)
    uv_areas = flat_areas(np.asarray(mesh.visual.uv), mesh.faces)
    assert uv_areas == pytest.approx(flat_areas(garment.uv, garment.uv_faces)[order], rel=1e-3, abs=1e-8)
    outward = np.einsum("ij,ij->i", mesh.face_normals, mesh.triangles_center * [1.0, 0.0, 1.0])
    assert (outward > 0.0).all()


def test_obj_stays_welded_and_holds_no_foreign_line(garment, tmp_path: Path) -> None:
    """Fails if positions doubled along seams, or a panel's name could add a face."""
    (path,) = write_meshes(garment, garment.nodes, tmp_path, "detail", ("obj",))
    lines = path.read_text().splitlines()
    count = {key: sum(line.startswith(key + " ") for line in lines) for key in ("v", "vt", "f", "g")}
    assert count == {"v": len(garment.nodes), "vt": len(garment.uv), "f": len(garment.faces), "g": 2}
    assert "g back_f_1_1_1" in lines


def test_uv_islands_do_not_overlap(garment) -> None:
    """Fails if two panels shared cloth on the uv plane, or a panel were turned or scaled."""
    uv = uv_layout(garment)
    boxes = []
    for panel in range(2):
        own = garment.panel_of_uv == panel
        boxes.append((uv[own].min(axis=0), uv[own].max(axis=0)))
        moved = uv[own] - garment.uv[own]
        assert moved == pytest.approx(np.broadcast_to(moved[0], moved.shape), abs=1e-12)
    (low, high), (other_low, other_high) = boxes
    assert (high < other_low).any() or (other_high < low).any()
    assert uv.min() >= 0.0


@pytest.mark.parametrize("stacked", [False, True])
def test_shelves_keep_boxes_apart(stacked: bool) -> None:
    """Fails if a shelf were as high as its last box, or a wide box hid another."""
    sizes = np.random.default_rng(2).uniform(0.02, 0.9, (25, 2))
    sizes[3, 0] = 4.0
    corners = pack_on_shelves(sizes, 0.01, 1.5, stacked)
    for i in range(len(sizes)):
        for j in range(i):
            gap = np.maximum(corners[i] - corners[j] - sizes[j], corners[j] - corners[i] - sizes[i])
            assert gap.max() >= 0.01 - 1e-12
