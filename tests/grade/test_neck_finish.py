"""What is sewn to a neckline is chosen by the cloth that a scan shows there."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.parts.cut import Collar, Front, Hood, HoodWorn
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import face_areas, vertex_normals
from garmentq.core.recover.drape.stage import drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.grade.choice import choose_cut
from garmentq.core.recover.grade.neck_finish import NeckShape, measure_slit, rank_finishes
from garmentq.core.scan.contours.category import choose_category
from garmentq.core.scan.contours.target import Contour, Target
from garmentq.core.scan.contours.turned import find_turned_faces

BARE = NeckShape(
    turned=0.0, depth=0.0, behind=0.0, standing=0.001, slope=0.6, slit=0.0, is_open=False, corners=0, length=0.6
)
"""A T-shirt's."""

SEEN = {
    (Collar.NONE, Front.NONE): BARE,
    (Collar.NONE, Front.OPEN): NeckShape(0.0, 0.0, 0.0, 0.0003, 0.62, 0.0, True, 0, 0.6),
    (Collar.NONE, Front.PLACKET): NeckShape(0.0, 0.0, 0.0, 0.0, 0.55, 0.14, False, 1, 0.6),
    (Collar.STAND, Front.ZIP): NeckShape(0.0, 0.0, 0.0, 0.002, 0.33, 0.0, False, 0, 0.48),
    (Collar.TURTLENECK, Front.NONE): NeckShape(0.0, 0.0, 0.0, 0.017, 0.0, 0.0, False, 0, 0.41),
    (Collar.SHIRT, Front.BUTTONS): NeckShape(0.0251, 0.068, 0.43, 0.0104, 0.21, 0.0, False, 1, 0.685),
    (Collar.POLO, Front.PLACKET): NeckShape(0.0247, 0.103, 0.4, 0.0012, 0.2, 0.14, False, 2, 1.0),
    (Collar.NOTCHED, Front.OPEN): NeckShape(0.0364, 0.203, 0.37, 0.0005, 0.16, 0.0, True, 2, 0.76),
    (Collar.SHAWL, Front.BUTTONS): NeckShape(0.0406, 0.279, 0.33, 0.0, 0.2, 0.0, False, 0, 1.02),
}
"""Necks of drapes, the shirt's, the jacket's and the open one's by another simulator."""


@pytest.mark.parametrize(("collar", "front"), SEEN, ids=lambda part: str(part))
def test_a_collar_is_chosen_by_what_is_seen_of_it(collar: Collar, front: Front) -> None:
    """Breaks where one measure outweighs the others, or a closed front gets another closure than is usual."""
    cut = CUTS["long_sleeve_tshirt"]
    best = rank_finishes(SEEN[collar, front], cut, {})[0]
    assert (best.collar, best.front) == (collar, front)
    assert best.apply(cut).collar is collar


@pytest.mark.parametrize(
    ("worn", "shape"),
    [
        (HoodWorn.UP, NeckShape(0.0008, 0.07, 0.0, 0.135, 0.05, 0.0, False, 2, 0.748)),
        (HoodWorn.DOWN, NeckShape(0.0013, -0.02, 1.0, 0.0212, 0.25, 0.064, False, 2, 0.722)),
        (HoodWorn.DOWN, NeckShape(0.083, 0.20, 0.87, 0.004, 0.05, 0.0, False, 4, 0.858)),
    ],
    ids=str,
)
def test_a_hood_is_chosen_as_it_is_worn(worn: HoodWorn, shape: NeckShape) -> None:
    """Breaks where a hood on the head is a turtleneck, or one behind the neck a jacket's lapels."""
    best = rank_finishes(shape, CUTS["long_sleeve_tshirt"], {})[0]
    assert (best.collar, best.hood, best.hood_worn) == (Collar.NONE, Hood.TWO, worn)
    fixed = rank_finishes(shape, CUTS["long_sleeve_tshirt"], {"hood": "three"})
    assert {one.hood for one in fixed} == {Hood.THREE}


def test_choices_of_the_user_stay() -> None:
    """Breaks where the scan overrules a part that the user chose, or a collar is sewn to a V."""
    cut = CUTS["tshirt"]
    assert {one.collar for one in rank_finishes(BARE, cut, {"collar": "polo"})} == {Collar.POLO}
    assert {one.front for one in rank_finishes(BARE, cut, {"front": "zip"})} == {Front.ZIP}
    shirt = SEEN[Collar.SHIRT, Front.BUTTONS]
    assert [one.collar for one in rank_finishes(shirt, cut, {"neckline": "v"})] == [Collar.NONE]


def test_what_cannot_be_drafted_is_no_choice() -> None:
    """Breaks where a suit, whose front is sewn at the centre, gets a shirt's buttons and the recovery ends there."""
    best = rank_finishes(SEEN[Collar.SHIRT, Front.BUTTONS], CUTS["sleeved_jumpsuit"], {})
    assert Collar.SHIRT not in {one.collar for one in best}


@pytest.mark.parametrize(("depth", "width", "length"), [(0.15, 0.01, 0.15), (0.15, 0.06, 0.0), (0.0, 0.01, 0.0)])
def test_a_slit_is_as_long_as_its_edges_are_beside_each_other(depth: float, width: float, length: float) -> None:
    """Breaks where a V counts as a slit, or the round edge above is counted with it."""
    angle = np.linspace(-np.pi / 2, 1.5 * np.pi, 200)[1:-1]
    ring = 0.1 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    down = np.linspace(0.0, depth, 40)[1:] if depth else np.zeros(0)
    start = ring[0] * (0.0, 1.0)
    left = np.stack([width / 2 * (1.0 - down / max(depth, 1.0)), start[1] - down], axis=1)
    loop = np.concatenate([ring[::-1], left * (-1.0, 1.0), left[::-1]])
    points = np.stack([loop[:, 0], loop[:, 1], np.zeros(len(loop))], axis=1)
    assert measure_slit(points) == pytest.approx(length, abs=0.012)


def test_what_faces_the_body_from_the_edge_on_is_turned_over() -> None:
    """Breaks where a flat neck is turned, or a fall is measured with its stand."""
    body = builtin_body("builtin:female,height=1.70")
    angle = np.arange(60) * 2.0 * np.pi / 60
    radii, heights = np.array([0.16, 0.10, 0.10, 0.14]), np.array([-0.06, -0.04, 0.0, -0.03])
    ring = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    vertices = (body.joint("neck") + radii[:, None, None] * ring + heights[:, None, None] * (0.0, 1.0, 0.0)).reshape(
        -1, 3
    )
    i, j = np.meshgrid(np.arange(3), np.arange(60), indexing="ij")
    a, b = 60 * i + j, 60 * i + (j + 1) % 60
    faces = np.stack([a, b, b + 60, a, b + 60, a + 60], axis=-1).reshape(-1, 3)
    for rings, turned in ((3, False), (4, True)):
        shown = faces[(faces < 60 * rings).all(axis=1)]
        edge = Contour("neck", np.arange(60 * (rings - 1), 60 * rings), 0.8)
        found = find_turned_faces(vertices, shown, edge, body)
        assert found.any() == turned
    slope = np.hypot(0.04, 0.03)
    assert face_areas(vertices, faces)[found].sum() == pytest.approx(np.pi * (0.10 + 0.14) * slope, rel=0.02)


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name", ["tshirt+collar=polo,front=placket", "long_sleeve_tshirt+collar=notched,front=open", "tshirt"]
)
def test_a_drape_is_recognised(name: str) -> None:
    """Breaks where what is measured of a drape is not what the draft predicts."""
    wearer = WearerGeometry(builtin_body("builtin:female,height=1.70,pose=A"))
    worn = drape_template(load_template(name), wearer)
    category = choose_category(worn.contours, worn.nodes, wearer.body)
    target = Target(worn.nodes, worn.faces, vertex_normals(worn.nodes, worn.faces), worn.contours, (), category)
    assert choose_cut(target, wearer.body).template == name
