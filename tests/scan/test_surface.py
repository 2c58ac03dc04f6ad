"""Clouds get normals and a surface, dense meshes a thin one, and all keep what they know of their points."""

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.point_normals import find_normals, orient_normals, thin_points
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.scan.raw import RawScan
from garmentq.core.scan.reconstruct import SurfaceFailed, measure_spacing, reconstruct
from garmentq.core.scan.thin import thin_raw_scan

BODY = builtin_body("builtin:female,height=1.70")
MESH = trimesh.Trimesh(BODY.vertices, BODY.faces, process=False)
POINTS, FACE = trimesh.sample.sample_surface(MESH, 12_000, seed=0)
POINTS = POINTS + np.random.default_rng(1).normal(0.0, 0.001, POINTS.shape)
NORMALS = np.array(MESH.face_normals[FACE])


def test_normals_without_and_with_a_body():
    """Broken where planes through neighbours miss the surface, or the body below does not turn them outward."""
    found = find_normals(POINTS)
    cosine = np.einsum("ij,ij->i", found, NORMALS)
    assert np.median(np.abs(cosine)) > 0.98 and 0.2 < (cosine > 0).mean() < 0.8
    thinner = BODY.vertices - 0.01 * np.array(MESH.vertex_normals)
    turned = orient_normals(POINTS, found, thinner, np.array(MESH.vertex_normals))
    assert (np.einsum("ij,ij->i", turned, NORMALS) > 0).mean() > 0.97  # fingers and ears have no plane


def test_thin_points_are_even():
    """Broken where a dense part keeps its density, or nothing is left of a sparse one."""
    dense = POINTS[POINTS[:, 1] > 1.2]
    points = np.concatenate(
        [POINTS, *(dense + np.random.default_rng(k).normal(0, 0.002, dense.shape) for k in range(9))]
    )
    rows = thin_points(points, 5000)
    assert 3500 <= len(rows) <= 6000
    share = (points[rows, 1] > 1.2).mean()
    assert abs(share - (POINTS[:, 1] > 1.2).mean()) < 0.1


def test_a_surface_is_the_same_bytes_twice():
    """Broken where threads or a seed of time decide the surface of a cloud, here or in the limited process."""
    here, there = (reconstruct(POINTS, NORMALS, is_confined=confined) for confined in (True, False))
    assert here.vertices.tobytes() == there.vertices.tobytes() and here.faces.tobytes() == there.faces.tobytes()
    assert TriangleSurface(here.vertices, here.faces).distance(BODY.vertices).mean() < 0.002
    made = trimesh.Trimesh(here.vertices, here.faces, process=False)
    assert made.volume == pytest.approx(MESH.volume, rel=0.03)


def test_a_surface_ends_where_the_points_end():
    """Broken where Poisson closes what nobody saw, the rim is not marked, or labels and colours change places."""
    kept = POINTS[:, 1] < 1.3
    points, labels = POINTS[kept], np.where(POINTS[kept][:, 0] > 0.0, "left", "right")
    colours = np.stack([points[:, 0] > 0.0] * 3, axis=1).astype(float)
    surface = reconstruct(points, NORMALS[kept], colours, labels, is_confined=True)
    assert surface.vertices[:, 1].max() < 1.3 + 2.5 * measure_spacing(points)
    rim = surface.vertices[surface.unseen]
    assert len(rim) > 20 and np.median(np.abs(rim[:, 1] - 1.3)) < 0.02
    inner = np.abs(surface.vertices[:, 0]) > 0.03
    assert np.array_equal(surface.labels[inner] == "left", surface.vertices[inner, 0] > 0.0)
    assert np.array_equal(surface.colours[:, 0] == 1.0, surface.labels == "left")


def test_no_surface_of_what_is_none():
    """Broken where points all over a room become a surface, and not an error with a code."""
    rng = np.random.default_rng(0)
    points = rng.normal(0.0, 1.0, (300, 3)) ** 3
    normals = rng.normal(0.0, 1.0, (300, 3))
    try:
        found = reconstruct(points, normals / np.linalg.norm(normals, axis=1)[:, None], is_confined=True)
        assert len(found.faces) < 3000
    except SurfaceFailed as error:
        assert error.code == "scan.no_surface"


def make_raw(points, faces, normals):
    """Return a raw scan whose file has its points twice, the second time without a use."""
    own = np.arange(len(points))
    place = np.concatenate([own, own])
    place[-3:] = -1
    return RawScan(points, faces, normals, True, np.abs(normals), own % 3, own, place)


@pytest.mark.parametrize("is_cloud", [False, True])
def test_thinning_keeps_places(is_cloud):
    """Broken where what is found for a thinned point is carried to another place of the file."""
    if is_cloud:
        raw = make_raw(POINTS, np.zeros((0, 3), np.int64), NORMALS)
        small = thin_raw_scan(raw, 4000)
        assert 1000 < len(small.points) < 3000
    else:
        raw = make_raw(BODY.vertices, BODY.faces, np.array(MESH.vertex_normals))
        small = thin_raw_scan(raw, 4000)
        assert 3000 < len(small.faces) <= 4200
        assert TriangleSurface(small.points, small.faces).distance(raw.points).mean() < 0.004
    assert np.array_equal(small.place < 0, raw.place < 0)
    kept = raw.place >= 0
    moved = np.linalg.norm(small.points[small.place[kept]] - raw.points[raw.place[kept]], axis=1)
    assert np.median(moved) < 0.02 and moved.max() < 0.12
    assert len(small.labels) == len(small.colours) == len(small.normals) == len(small.points)
    assert thin_raw_scan(small, 10_000) is small
