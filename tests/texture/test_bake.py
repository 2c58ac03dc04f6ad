"""Colours of a scan come back on the pattern, at the right place and on both sides of a seam."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from garmentq.core.deliver.export.sewn_mesh import square_layout
from garmentq.core.deliver.texture.bake import TexelBad, bake_texture, check_texel
from garmentq.core.deliver.texture.texels import find_texels
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.scan.coloured import ColouredScan
from garmentq.core.scan.texture import sample_image

TEXEL = 1e-3
COARSE = 2e-3


@pytest.fixture(scope="module")
def garment() -> Garment:
    """Return a T-shirt as it hangs on the built-in body."""
    found = load_draped_template("tshirt")
    if found is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return found


def refine(garment: Garment, times: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions [m], flat places [m] and faces of the garment cut open, halved so often."""
    points, faces = np.column_stack([garment.nodes[garment.uv_node], garment.uv]), garment.uv_faces
    for _ in range(times):
        points, faces = trimesh.remesh.subdivide(points, faces)
    return points[:, :3], points[:, 3:], faces


def by_flat_place(flat: np.ndarray) -> np.ndarray:
    """Return a colour for each flat place [m]: 100 of 255 up and down within 26 cm."""
    return np.stack(
        [
            127.0 + 100.0 * np.sin(12.0 * flat[:, 0]),
            127.0 + 100.0 * np.cos(12.0 * flat[:, 1]),
            90.0 + 200.0 * flat[:, 1],
        ],
        axis=1,
    )


def by_position(points: np.ndarray) -> np.ndarray:
    """Return a colour for each position [m], 1 mm of which changes a channel by at most 0.4 of 255."""
    return np.clip(127.0 + 400.0 * (points - [0.0, 1.2, 0.0]), 0.0, 255.0)


def colour(points: np.ndarray, faces: np.ndarray, colours: np.ndarray) -> ColouredScan:
    """Return a scan with colours of its vertices."""
    bytes_ = np.clip(np.round(colours), 0, 255).astype(np.uint8)
    return ColouredScan(points, faces, bytes_, np.zeros((len(faces), 3, 2)), np.full(len(faces), -1))


def bake(garment: Garment, scan: ColouredScan, texel: float = TEXEL):
    """Bake, and return the texture with its coordinates."""
    flat, side = square_layout(garment)
    return bake_texture(garment, garment.nodes, scan, flat, side, texel), flat


def test_colours_by_flat_place_come_back_at_their_place(garment: Garment) -> None:
    """Fails if a texel is half a millimetre off, v runs the wrong way, or cloth is left out: 2 % of the range."""
    points, flat_places, faces = refine(garment, 2)
    rng = np.random.default_rng(0)
    noisy = points + 3e-4 * rng.normal(size=points.shape) * 0.3  # a scanner's noise, and another triangulation
    baked, flat = bake(garment, colour(noisy, faces, by_flat_place(flat_places)))
    texels = find_texels(flat, garment.uv_faces, len(baked.image), 0.0)
    places = np.einsum("nk,nkd->nd", texels.barycentric, garment.uv[garment.uv_faces[texels.face]])
    true = np.clip(by_flat_place(places), 0.0, 255.0)
    error = np.abs(baked.image[texels.row, texels.column] - true) / 255.0
    assert error.mean() < 0.005  # the promise is 0.02
    assert np.quantile(error, 0.99) < 0.03
    assert baked.coverage > 0.995
    area = trimesh.triangles.area(np.pad(garment.uv, ((0, 0), (0, 1)))[garment.uv_faces]).sum()
    assert baked.cloth.sum() * TEXEL**2 == pytest.approx(area, rel=1e-3)


def test_both_sides_of_a_seam_show_the_same_colour(garment: Garment) -> None:
    """Fails if a panel's border reads the ground beside it: colours by position differ by what 1 mm of it makes."""
    points, _, faces = refine(garment, 2)
    baked, flat = bake(garment, colour(points, faces, by_position(points)))
    for seam in garment.pattern.seams:
        a, b = garment.edge_uv[seam.a], garment.edge_uv[seam.b][::-1]
        share = np.linspace(0.0, 1.0, 5)[:, None, None]
        first, second = (((1.0 - share) * flat[side[:-1]] + share * flat[side[1:]]).reshape(-1, 2) for side in (a, b))
        apart = np.abs(sample_image(baked.image, first) - sample_image(baked.image, second))
        assert apart.max() <= 0.4 + 1.0  # 1 mm, and a byte's rounding on either side


def test_a_hole_of_the_scan_is_masked_and_filled_from_around_it(garment: Garment) -> None:
    """Fails if a hole counts as seen, takes the colour of another layer, or stays white."""
    points, _, faces = refine(garment, 2)
    centre = points[np.argmax(points[:, 2] - 5.0 * np.abs(points[:, 0]))]  # the middle of the chest
    near = np.linalg.norm(points[faces].mean(axis=1) - centre, axis=1) < 0.03
    baked, _ = bake(garment, colour(points, faces[~near], by_position(points)), COARSE)
    missing = baked.cloth & ~baked.covered
    assert missing.sum() * COARSE**2 == pytest.approx(np.pi * 0.03**2, rel=0.4)
    shown = baked.image[missing].astype(float)
    around = by_position(centre[None])[0]
    assert np.abs(shown - around).max() < 400.0 * 0.045  # what 3 cm and the fold of the cloth make


def test_faces_that_look_inward_are_read_too(garment: Garment) -> None:
    """Fails if a file whose faces are all turned gives no colour."""
    points, _, faces = refine(garment, 2)
    baked, _ = bake(garment, colour(points, faces[:, ::-1], by_position(points)), COARSE)
    assert baked.coverage > 0.995


def test_the_other_layer_s_colours_do_not_come_through(garment: Garment) -> None:
    """Fails if a lining 1 mm behind the cloth, nearer to the garment than the scan, gives its colour."""
    points, _, faces = refine(garment, 2)
    red, blue = np.tile([200.0, 0.0, 0.0], (len(points), 1)), np.tile([0.0, 0.0, 200.0], (len(points), 1))
    normal = vertex_normals(garment.nodes, garment.faces)[garment.uv_node]
    fine = np.column_stack([garment.nodes[garment.uv_node], normal])
    turned = garment.uv_faces
    for _ in range(2):
        fine, turned = trimesh.remesh.subdivide(fine, turned)
    outer = points + 2e-3 * fine[:, 3:]
    inner = points - 1e-3 * fine[:, 3:]
    scan = colour(
        np.concatenate([outer, inner]), np.concatenate([faces, faces[:, ::-1] + len(points)]),
        np.concatenate([red, blue]),
    )  # fmt: skip
    baked, _ = bake(garment, scan, COARSE)
    shown = baked.image[baked.cloth]
    assert (shown[:, 0] > shown[:, 2]).mean() > 0.99


@pytest.mark.parametrize("width", [0.0, 0.3, -1.0, float("nan")])
def test_texels_of_other_sizes_are_refused(width: float) -> None:
    """Fails if a texture of any size could be asked for."""
    with pytest.raises(TexelBad):
        check_texel(width)
