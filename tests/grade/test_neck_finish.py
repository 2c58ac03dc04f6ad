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
from garmentq.core.recover.grade.neck_finish import (
    DENSITY_EXPONENT,
    DRAPES,
    NECK_KINDS,
    RARE_COST,
    RARE_STYLES,
    NeckKind,
    NeckStyle,
    ShownSides,
    fit_densities,
    load_densities,
    rank_finishes,
)
from garmentq.core.recover.grade.neck_shape import NeckShape, measure_slit
from garmentq.core.scan.contours.category import choose_category
from garmentq.core.scan.contours.target import Contour, Target
from garmentq.core.scan.contours.turned import find_turned_faces


def make_shape(style: NeckStyle, is_open: bool = False, slit: float = 0.0) -> NeckShape:
    """Return the mean neck of the drapes of a style."""
    (mean,) = (
        density.mean
        for density in load_densities()
        if density.kind == NeckKind(style, is_open=is_open) and density.sides is ShownSides.BOTH
    )
    turned, standing, height, length, depth, corners = mean[3:]
    return NeckShape(
        mean[:3], turned**2, depth, standing**2, height, float(np.exp(length)), round(corners), slit, is_open
    )


SEEN = {
    (Collar.NONE, Front.NONE): make_shape(NeckStyle.PLAIN),
    (Collar.NONE, Front.OPEN): make_shape(NeckStyle.PLAIN, True),
    (Collar.NONE, Front.PLACKET): make_shape(NeckStyle.PLAIN, slit=0.14),
    (Collar.STAND, Front.ZIP): make_shape(NeckStyle.STAND),
    (Collar.TURTLENECK, Front.NONE): make_shape(NeckStyle.TURTLENECK),
    (Collar.SHIRT, Front.BUTTONS): make_shape(NeckStyle.FALL),
    (Collar.SHIRT, Front.OPEN): make_shape(NeckStyle.FALL, True),
    (Collar.POLO, Front.PLACKET): make_shape(NeckStyle.FALL, slit=0.14),
    (Collar.NOTCHED, Front.BUTTONS): make_shape(NeckStyle.LAPELS),
    (Collar.NOTCHED, Front.OPEN): make_shape(NeckStyle.LAPELS, True),
    (Collar.SHAWL, Front.BUTTONS): make_shape(NeckStyle.SHAWL),
}
"""Necks with collars and fronts."""

BARE = SEEN[Collar.NONE, Front.NONE]
"""A T-shirt's."""


@pytest.mark.parametrize(("collar", "front"), SEEN, ids=lambda part: str(part))
def test_a_collar_is_chosen_by_what_is_seen_of_it(collar: Collar, front: Front) -> None:
    """Breaks where one measure outweighs the others, or a closed front gets another closure than is usual."""
    cut = CUTS["long_sleeve_tshirt"]
    best = rank_finishes(SEEN[collar, front], cut, {})[0]
    assert (best.collar, best.front, best.hood) == (collar, front, Hood.NONE)
    assert best.misfit == 0.0 and best.apply(cut).collar is collar


HOOD_DOWN = NeckShape(
    slopes=np.array([0.48, 0.24, 0.22]), turned=0.0013, depth=-0.018, standing=0.0212, height=0.025, length=0.72,
    corners=2, slit=0.064, is_open=False,
)  # fmt: skip
"""A sweatshirt's, draped by another simulator."""


@pytest.mark.parametrize(
    ("worn", "shape"), [(HoodWorn.UP, make_shape(NeckStyle.HOOD_UP)), (HoodWorn.DOWN, HOOD_DOWN)], ids=str
)
def test_a_hood_is_chosen_as_it_is_worn(worn: HoodWorn, shape: NeckShape) -> None:
    """Breaks where a hood on the head is a turtleneck, or one behind the neck a jacket's lapels."""
    best = rank_finishes(shape, CUTS["long_sleeve_tshirt"], {})[0]
    assert (best.collar, best.hood, best.hood_worn) == (Collar.NONE, Hood.TWO, worn)
    fixed = rank_finishes(shape, CUTS["long_sleeve_tshirt"], {"hood": "three"})
    assert {one.hood for one in fixed} == {Hood.THREE}


@pytest.mark.parametrize(("sides", "right", "plain"), [(ShownSides.BOTH, 0.75, 0.95), (ShownSides.OUTSIDE, 0.45, 0.9)])
def test_drapes_that_are_left_out_are_recognised(sides: ShownSides, right: float, plain: float) -> None:
    """Breaks where a covariance is fitted to few drapes, or a plain neck gets a collar (0.84, 0.98; 0.52, 0.95)."""
    with np.load(DRAPES) as stored:
        samples = {name: stored[name].astype(np.float64) for name in stored.files}
    found: dict[bool, list[bool]] = {False: [], True: []}
    for name, rows in samples.items():
        kind = next(one for one in NECK_KINDS if one.name == name.split("/")[0])
        if not name.endswith(sides):
            continue
        for i, row in enumerate(rows):
            others = fit_densities(samples | {name: np.delete(rows, i, axis=0)})
            scores = {
                one.kind: DENSITY_EXPONENT * one.log_density(row) - RARE_COST**2 / 2 * (one.kind.style in RARE_STYLES)
                for one in others
                if one.sides is sides and one.kind.is_open == kind.is_open
            }
            is_right = max(scores, key=lambda one: scores[one]).style is kind.style
            found[kind.style is NeckStyle.PLAIN].append(is_right)
    assert np.mean(found[False] + found[True]) > right
    assert np.mean(found[True]) > plain


def test_probabilities_are_those_of_what_is_seen() -> None:
    """Breaks where collars that look alike share a probability, or one that the user chose is doubted."""
    cut, shirt = CUTS["tshirt"], SEEN[Collar.SHIRT, Front.BUTTONS]
    found = rank_finishes(shirt, cut, {})
    alike = [one.probability for one in found if one.collar in (Collar.SHIRT, Collar.CONVERTIBLE)]
    assert len(set(alike)) == 1 and 0.5 < alike[0] < 1.0
    assert {one.probability for one in rank_finishes(shirt, cut, {"collar": "polo"})} == {1.0}
    assert all(np.isfinite(one.misfit) for one in rank_finishes(shirt, cut, {"collar": "turtleneck", "front": "open"}))


def test_choices_of_the_user_stay() -> None:
    """Breaks where the scan overrules a part that the user chose, or a collar is sewn to a V."""
    cut = CUTS["tshirt"]
    assert {one.collar for one in rank_finishes(BARE, cut, {"collar": "polo"})} == {Collar.POLO}
    assert {one.collar for one in rank_finishes(BARE, cut, {"collar": "rib"})} == {Collar.RIB}
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
