"""A wrapped front is told from a V neck by the step of its outer front's edge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.neckline_fit import NecklineFit, NecklineFits
from garmentq.core.garment.parts.cut import Collar, Cut, Front, Neckline
from garmentq.core.garment.parts.necklines import NecklineCut
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.grade.front_heights import CELL_SIZE, FrontHeights, front_frame
from garmentq.core.recover.grade.lap import Lap, LapSettings, find_lap
from garmentq.core.recover.grade.neck_finish import RARE_COST, NeckFinish, ShownSides
from garmentq.core.recover.grade.wrap_choice import add_wrap, draw_wrapped_necklines, unwrap
from garmentq.core.recover.start import free_wrapped_neck
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import Contour, Target

BODY = builtin_body("builtin:female,height=1.70")
POINT = np.array([0.0, -0.15])
"""The point of the V, to the wearer's left and above the neck joint [m]."""


def draw_front(step: float, noise: float = 0.0005, side: float = 1.0) -> Target:
    """Return the front of a top with a V neck, and a step from its point towards the left, or the right (-1) [m]."""
    x, y = np.meshgrid(np.arange(-0.2, 0.2001, 0.005), np.arange(-0.6, 0.0001, 0.005))
    rng = np.random.default_rng(0)
    slope = np.arctan2(0.15, 0.08) + np.radians(8.0)
    below = np.cos(slope) * (POINT[1] - y) - np.sin(slope) * (side * x - POINT[0])
    z = 0.1 + 0.004 * np.sin(40.0 * x) - 1.5 * x**2 + step * 0.5 * np.tanh(below / 0.004) * (side * x > -0.005)
    points = np.stack([x, y, z + noise * rng.normal(size=x.shape)], axis=-1).reshape(-1, 3)
    rows, columns = x.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, 1:].ravel(), index[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    is_cloth = points[:, 1] < POINT[1] + np.abs(points[:, 0]) * 0.15 / 0.08
    faces = faces[is_cloth[faces].all(axis=1)]
    used, faces = np.unique(faces, return_inverse=True)
    vertices = BODY.joint("neck") + points[used] @ front_frame(BODY).T
    faces = faces.reshape(-1, 3)
    loop = find_loops(faces, vertices)[0]
    neck = Contour("neck", loop[(vertices[loop] - BODY.joint("neck"))[:, 1] > POINT[1] - 0.01], 0.4)
    return Target(vertices, faces, vertex_normals(vertices, faces), (neck,), (), "tank")


def test_a_step_is_told_from_slopes_and_level_cloth() -> None:
    """Breaks where the kernel feels a slope, or does not give a step's height."""
    kernel = LapSettings().kernel()
    place = (np.arange(len(kernel)) - len(kernel) // 2) * CELL_SIZE
    assert kernel @ np.ones(len(place)) == pytest.approx(0.0, abs=1e-12)
    assert kernel @ place == pytest.approx(0.0, abs=1e-12)
    assert kernel @ np.where(place > 0.0, 0.003, 0.001) == pytest.approx(0.002, rel=1e-9)


def test_heights_are_those_of_the_outermost_cloth() -> None:
    """Breaks where a cell has the height of another place, or of the layer below."""
    target = draw_front(0.0, noise=0.0)
    inner = target.vertices - 0.01 * front_frame(BODY)[:, 2]
    both = np.concatenate([inner, target.vertices])
    faces = np.concatenate([target.faces, target.faces + len(inner)])
    found = FrontHeights.of(replace(target, vertices=both, faces=faces), BODY)
    assert found is not None
    x, y = np.array([0.05, -0.1, 0.15]), np.array([-0.3, -0.5, -0.2])
    heights, known = found.sample(x, y)
    assert known.all()
    assert heights == pytest.approx(0.1 + 0.004 * np.sin(40.0 * x) - 1.5 * x**2, abs=1.5e-3)


@pytest.mark.parametrize("step", [0.002, 0.003])
def test_a_lap_is_found_at_the_point_of_a_vee(step: float) -> None:
    """Breaks where a step of two layers is lost in noise, or one of the left front over the right one is found."""
    lap, plain, mirrored = (
        find_lap(draw_front(*one), BODY, ShownSides.OUTSIDE) for one in ((step,), (0.0,), (step, 0.0005, -1.0))
    )
    assert lap is not None and plain is not None and mirrored is not None
    assert lap.log_odds > 0.5 * RARE_COST**2 > 0.0 > plain.log_odds
    assert mirrored.log_odds < 0.0
    assert 0.15 < lap.extent < 0.3


def test_a_covered_border_leaves_no_doubt() -> None:
    """Breaks where the border of a garment that was scanned by itself counts less than a step of its surface, or a left
    front over a right one, which is not drafted, is drafted the other way."""
    target = draw_front(0.0)
    down = np.linspace(0.0, 0.12, 15)[:, None]
    outer = [0.0, POINT[1], 0.102] + down * [0.5, -1.0, 0.0]
    inner = [0.0, POINT[1], 0.08] + down * [-0.5, -1.0, 0.0]
    for ends, is_found in (((inner, outer), True), ((outer, inner), False)):
        border = np.concatenate([ends[0], ends[1][::-1]])
        vertices = np.concatenate([target.vertices, BODY.joint("neck") + border @ front_frame(BODY).T])
        line = Contour("wrap", len(target.vertices) + np.arange(len(border)), 0.1, is_closed=False)
        both = replace(target, vertices=vertices, contours=(*target.contours, line))
        lap = find_lap(both, BODY)
        assert (lap is not None and lap.log_odds == np.inf) is is_found
    (wrap,) = add_wrap([SHIRT], Lap(0.3, np.inf), NecklineFits((SQUARE,), (CREW,)), CUTS["tshirt"], {})
    assert (wrap.collar, wrap.front, wrap.misfit, wrap.probability) == (Collar.NONE, Front.WRAP, 0.0, 1.0)


PLAIN, SHIRT = NeckFinish(Collar.NONE, Front.NONE, probability=0.9), NeckFinish(Collar.SHIRT, Front.BUTTONS, misfit=1.5)
VEE = NecklineFit(NecklineCut(Neckline.V, 0.12), 0.08, 0.02)
ROUND = NecklineFit(NecklineCut(Neckline.SCOOP, 0.12), 0.08, 0.05)
CREW = NecklineFit(NecklineCut(Neckline.CREW, 0.08), 0.08, 0.05)
SQUARE = NecklineFit(NecklineCut(Neckline.SQUARE, 0.12), 0.08, 0.05)
SEEN = NecklineFits((VEE, ROUND), (CREW,))


def test_a_wrap_has_to_outweigh_that_it_is_rare() -> None:
    """Breaks where even odds choose a wrap, its share is not taken off the plain neck's, or the order is not by
    likelihood."""
    for odds, first in ((0.0, Front.NONE), (1.9, Front.NONE), (2.1, Front.WRAP), (9.0, Front.WRAP)):
        found = add_wrap([PLAIN, SHIRT], Lap(0.3, odds), SEEN, CUTS["tshirt"], {})
        assert found[0].front is first and found[0].misfit == 0.0
        assert [one.misfit for one in found] == sorted(one.misfit for one in found)
    both = {one.front: one for one in add_wrap([PLAIN], Lap(0.3, 2.0), SEEN, CUTS["tshirt"], {})}
    assert both[Front.WRAP].probability == pytest.approx(0.45)
    assert both[Front.NONE].probability == pytest.approx(0.45)
    assert both[Front.WRAP].misfit == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("fits", "fixed"),
    [
        (SEEN, {"front": "none"}),
        (SEEN, {"neckline": "crew"}),
        (SEEN, {"shaping": "darts"}),
        (NecklineFits((SQUARE,), (CREW,)), {}),
    ],
)
def test_what_is_fixed_or_seen_otherwise_is_no_wrap(fits: NecklineFits, fixed: dict[str, str]) -> None:
    """Breaks where the user's choice is overruled, or a square neck is wrapped."""
    assert add_wrap([PLAIN], Lap(0.3, 9.0), fits, CUTS["tshirt"], fixed) == (PLAIN,)
    assert add_wrap([PLAIN], None, SEEN, CUTS["tshirt"], {}) == (PLAIN,)
    assert add_wrap([SHIRT], Lap(0.3, 9.0), SEEN, CUTS["tshirt"], {}) == (SHIRT,)


def test_a_wrap_is_cut_with_a_vee_of_the_depth_that_is_seen() -> None:
    """Breaks where a point that the scan rounds makes a scoop, or girths are measured on both layers."""
    (front,) = draw_wrapped_necklines(replace(SEEN, front=(ROUND,))).front
    assert front.neckline.kind is Neckline.V and front.neckline.depth == ROUND.neckline.depth
    wrap = replace(PLAIN, front=Front.WRAP)
    cut: Cut = wrap.apply(CUTS["tshirt"])
    assert (cut.front, cut.neckline) == (Front.WRAP, Neckline.V)
    assert unwrap([wrap, SHIRT]) == (PLAIN, SHIRT)


def test_the_neckline_of_a_wrap_is_neither_fitted_nor_measured() -> None:
    """Breaks where the seen neckline is compared with front edges that go on below it, or a plain one is freed."""
    target = draw_front(0.0)
    for name, is_trusted in (("tank+front=wrap,neckline=v", False), ("tank+neckline=v", True)):
        (neck,) = free_wrapped_neck(target, load_template(name)).contours
        assert neck.trusted is is_trusted
