"""A contour that was cut off by the scanner's frame is not trusted."""

import numpy as np
from garmentq.core.segment import name_contours

AROUND = 48


def trust(vertices, faces, body):
    """Give each contour's trust by name."""
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
