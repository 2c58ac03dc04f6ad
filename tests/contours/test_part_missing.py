"""Openings that no worn garment has are refused by name."""

import numpy as np
import pytest
from garmentq.core.scan.contours.garment import PartMissing, SeveralGarments, segment_garment
from garmentq.core.scan.scan import Scan


def test_half_a_shirt_is_refused(wearers, skin):
    """Half a T-shirt has a cuff and one long rim; it must not become a pattern of a whole one."""
    body = wearers["T"]
    vertices, faces = skin(body, "tshirt")
    half = faces[(vertices[faces, 0] > body.joint("pelvis")[0]).all(axis=1)]
    with pytest.raises(PartMissing, match=r"only cuff\.left could be named") as caught:
        segment_garment(Scan(vertices, half, name="half"), body)
    assert caught.value.code == "segment.part_missing"


def test_an_open_front_is_no_missing_part(wearers, opened):
    """A jacket's hem, fronts and neckline are one border of the surface: it must not be refused as half a garment."""
    body = wearers["T"]
    target = segment_garment(Scan(*opened(body, "tshirt", 0.06), name="jacket"), body)
    assert {"neck", "hem", "front.left", "front.right"} < {contour.name for contour in target.contours}


def test_upside_down_is_refused(wearers, hung):
    """A skirt standing on its head has a hem where no bone leaves it; it must not be taken for another garment."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.61, 0.35)
    segment_garment(Scan(vertices, faces, name="skirt"), body)
    sunk = vertices * [1.0, -1.0, -1.0] + [0.0, 2.0 * body.joint("pelvis")[1] - 0.75, 0.0]
    with pytest.raises(PartMissing):
        segment_garment(Scan(sunk, faces, name="skirt"), body)


def test_trousers_need_no_neck(wearers, skin):
    """A waist above and legs below make a garment: the check must not ask for more."""
    body = wearers["A"]
    assert segment_garment(Scan(*skin(body, "trousers")), body).category == "trousers"


def test_an_outfit_is_refused(wearers, skin, hung):
    """A T-shirt and a skirt in one file have a neck, cuffs and a hem; they must not pass for a dress with holes."""
    body = wearers["T"]
    shirt, skirt = skin(body, "tshirt"), hung(body, 0.61, 0.35)
    vertices, faces = join(shirt, skirt)
    with pytest.raises(SeveralGarments, match="more than one garment") as caught:
        segment_garment(Scan(vertices, faces, name="outfit"), body)
    assert caught.value.code == "segment.several_garments"


def test_a_garment_with_its_body_is_refused(wearers, hung):
    """A body in the garment's own file must not be graded to."""
    body = wearers["T"]
    with pytest.raises(SeveralGarments, match="closed as a body"):
        segment_garment(Scan(*join(hung(body, 0.61, 0.35), (body.vertices, body.faces)), name="both"), body)


def test_an_unsewn_waistband_belongs_to_its_skirt(wearers, hung):
    """Surfaces that lie edge to edge are one garment, though each has an opening below and one above."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.61, 0.35)
    upper = (faces >= vertices.shape[0] - 4 * 48).all(axis=1)
    parts = [(vertices, faces[upper]), (vertices, faces[~upper])]
    assert segment_garment(Scan(*join(*parts), name="skirt"), body).category == "skirt"


def join(*meshes):
    """Put meshes into one, as surfaces of their own, without the vertices that they do not use."""
    vertices, faces, start = [], [], 0
    for points, triangles in meshes:
        used, index = np.unique(triangles, return_inverse=True)
        vertices.append(points[used])
        faces.append(index.reshape(-1, 3) + start)
        start += len(used)
    return np.concatenate(vertices), np.concatenate(faces)
