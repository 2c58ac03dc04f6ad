"""A contour that was cut off by the scanner's frame is not trusted."""

import numpy as np
import pytest
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.scan.contours.contours import name_contours

AROUND = 48


def trust(vertices, faces, body):
    """Return each contour's trust by name."""
    contours, _ = name_contours(vertices, faces, body, scanned=True)
    return {contour.name: contour.trusted for contour in contours}


def cut_teeth(faces, rows):
    """Leave every second triangle of some rows of quads, as a cut along triangles does."""
    kept = np.ones(len(faces), bool)
    for row in rows:
        start = row % (len(faces) // (2 * AROUND)) * 2 * AROUND
        kept[start + (1 if row < 0 else 0) : start + 2 * AROUND : 2] = False
    return faces[kept]


def test_only_the_cut_hem_is_not_trusted(wearers, hung):
    """Broken where the teeth of a cut pass for design: the pattern would be graded to a hem that is not there."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.6, 0.3)
    assert trust(vertices, faces, body) == {"waist": True, "hem": True}
    assert trust(vertices, cut_teeth(faces, (0,)), body) == {"waist": True, "hem": False}


def test_a_garment_cut_out_along_triangles_is_trusted(wearers, hung):
    """Broken where every contour of such a garment is given up: nothing would hold its ends."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.6, 0.3)
    assert trust(vertices, cut_teeth(faces, (0, -1)), body) == {"waist": True, "hem": True}


def test_a_smooth_contour_of_few_edges_is_trusted(wearers, hung):
    """Broken where the turn that a coarse ring must take anyhow is read as teeth: a cuff of 14 edges was given up."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.6, 0.3, around=AROUND)
    fine = np.arange(AROUND)
    coarse = len(vertices) + np.round(fine / 4).astype(int) % (AROUND // 4)
    ring = vertices[:AROUND:4] * [1.0, 0.0, 1.0] + [0.0, vertices[0, 1] - 0.03, 0.0]
    after, next_coarse = np.roll(fine, -1), np.roll(coarse, -1)
    border = np.concatenate([np.stack([fine, coarse, after], 1), np.stack([coarse, next_coarse, after], 1)])
    border = border[(border[:, 0] != border[:, 1])]
    assert trust(np.concatenate([vertices, ring]), np.concatenate([faces, border]), body) == {
        "waist": True,
        "hem": True,
    }


def make_fine(vertices, faces, times):
    """Split every triangle into four, several times."""
    for _ in range(times):
        edges = HalfEdges.of(faces, len(vertices))
        middle = len(vertices) + edges.edge.reshape(-1, 3)
        vertices = np.concatenate([vertices, vertices[edges.edges].mean(axis=1)])
        (a, b, c), (ab, bc, ca) = faces.T, middle.T
        faces = np.concatenate([np.stack(row, 1) for row in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return vertices, faces


@pytest.fixture(scope="module")
def dense(wearers, hung):
    """Return a short tube with edges of 1.5 to 2.5 mm and 0.2 mm of noise, whose hem waves."""
    vertices, faces = hung(wearers["T"], 0.6, 0.55, around=1000, rows=40, wave=0.05)
    return vertices + 2e-4 * np.random.default_rng(0).standard_normal(vertices.shape), faces


def test_a_hem_of_a_dense_scan_is_trusted(wearers, dense):
    """Broken where noise between neighbouring vertices, 0.2 mm on edges of 2 mm, is read as teeth."""
    assert trust(*dense, wearers["T"]) == {"waist": True, "hem": True}


def test_a_cut_hem_of_a_dense_scan_is_not_trusted(wearers, dense):
    """Broken where teeth are looked for over a length that smooths a dense scan's own away."""
    vertices, faces = dense
    kept = np.ones(len(faces), bool)
    kept[:2000:2] = False
    assert trust(vertices, faces[kept], wearers["T"]) == {"waist": True, "hem": False}


def test_wide_teeth_of_fine_triangles_are_not_trusted(wearers, hung):
    """Broken where only neighbouring vertices are compared: most lie on the straight side of a tooth."""
    body = wearers["T"]
    coarse, faces = hung(body, 0.6, 0.55, around=160, rows=8)
    assert trust(*make_fine(coarse, faces, 2), body) == {"waist": True, "hem": True}
    kept = np.ones(len(faces), bool)
    kept[:320:2] = False
    assert trust(*make_fine(coarse, faces[kept], 2), body) == {"waist": True, "hem": False}


def test_a_scan_as_noisy_as_its_edges_is_trusted(wearers, hung):
    """Broken where noise that is larger than the edges is read as teeth, here or there by chance."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.6, 0.55, around=1000, rows=40)
    for seed in range(3):
        noisy = vertices + 2e-3 * np.random.default_rng(seed).standard_normal(vertices.shape)
        assert trust(noisy, faces, body) == {"waist": True, "hem": True}
