"""Wrong parts show in the shape of a drape's open contours, and right ones do not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.core.body import builtin_body
from garmentq.core.measure import judge, measure_contour_shapes, measure_plausibility
from garmentq.core.pattern import load_template
from garmentq.core.pattern.parts import CUTS, Neckline, Throat, draft_cut, neckline_points
from garmentq.core.segment import Contour, Target

BODY = builtin_body("builtin:female,height=1.70")

WIDTH = 0.10
"""Half width of the necks [m]."""


def neck(front: Throat, back: Throat) -> np.ndarray:
    """Return a neck contour: two drafted necklines, upright before and behind the neck."""
    ahead, behind = (neckline_points(throat, WIDTH, 60) for throat in (front, back))
    halves = [
        np.c_[line[:, 0], 1.42 + line[:, 1], side * 1.5 * line[:, 1]] for line, side in ((ahead, -0.3), (behind, 0.3))
    ]
    flip = np.array([-1.0, 1.0, 1.0])
    first, second = halves
    return np.concatenate([first[:-1], (first * flip)[:0:-1], (second * flip)[:-1], second[:0:-1]])


def compare(ours: np.ndarray, theirs: np.ndarray, name: str = "neck", trusted: bool = True) -> dict[str, float | None]:
    """Compare two closed lines as a contour of a drape and of a scan."""
    contour = Contour(name, np.arange(len(theirs)), 0.6, trusted=trusted)
    target = Target(theirs, np.zeros((0, 3), int), theirs, (contour,), (), "tshirt")
    garment = SimpleNamespace(contours=(Contour(name, np.arange(len(ours)), 0.6),))
    return measure_contour_shapes(garment, ours, target, BODY)


def verdicts(metrics: dict[str, float | None]) -> dict[str, str]:
    """Judge metrics, by gate."""
    return {gate.name: str(gate.verdict) for gate in judge(metrics)}


CREW = Throat.at_back(Neckline.CREW)
V = Throat(Neckline.V, 0.16)


def test_a_crew_neck_for_a_v_does_not_pass() -> None:
    """Breaks where another kind of neckline passes, in front or behind, or another depth does not."""
    scan = neck(V, CREW)
    assert verdicts(compare(scan, scan)) == {"neckline": "pass", "contour_shape": "pass"}
    assert verdicts(compare(neck(Throat(Neckline.V, 0.15), CREW), scan))["neckline"] == "pass"
    for depth in (0.10, 0.16):
        assert verdicts(compare(neck(Throat(Neckline.CREW, depth), CREW), scan))["neckline"] != "pass"
    assert verdicts(compare(scan, neck(Throat.at_front(Neckline.SCOOP), CREW)))["neckline"] != "pass"
    assert verdicts(compare(neck(V, Throat(Neckline.V, 0.12)), scan))["neckline"] != "pass"


def test_the_distance_of_necklines_is_measured_in_the_cloth() -> None:
    """Breaks where a drape that hangs lower, or leans more, is charged for it: only the unrolled lines count."""
    scan = neck(V, CREW)
    moved = compare(scan + [0.0, -0.03, 0.01], scan)
    assert moved["shape.neck_mm"] == pytest.approx(0.0, abs=0.5)
    deeper = compare(neck(Throat(Neckline.V, 0.19), CREW), scan)
    stretch = np.hypot(1.0, 0.45)  # of the leaning plane
    assert deeper["shape.neck_mm"] == pytest.approx(30.0 * stretch, abs=5.0)


def ring(height, radius: float = 0.2, folds: int = 0) -> np.ndarray:
    """Return a closed line around the y axis; `height` is a function of the angle."""
    angle = np.linspace(0.0, 2 * np.pi, 240, endpoint=False)
    wide = radius + 0.02 * np.sin(folds * angle)
    return np.stack([wide * np.sin(angle), height(angle), wide * np.cos(angle)], axis=1)


def test_folds_of_a_hem_do_not_count_and_its_dip_does() -> None:
    """Breaks where folds that fall elsewhere are a wrong part, or a tail at the back is averaged away."""
    level = ring(lambda a: 0.5 + 0.0 * a)
    folded = ring(lambda a: 0.5 + 0.008 * np.sin(9 * a), folds=9)
    assert compare(folded, level, "hem")["shape.hem_mm"] < 3.0
    tail = ring(lambda a: 0.5 - 0.05 * np.cos(a))
    assert compare(tail, level, "hem")["shape.hem_mm"] == pytest.approx(50.0, abs=8.0)


def test_a_cuff_is_measured_along_the_arm() -> None:
    """Breaks where a sleeve's length is measured downwards: the built-in body stretches its arms out."""
    along = np.stack([0.05 * np.cos(np.arange(60) * np.pi / 30), 0.05 * np.sin(np.arange(60) * np.pi / 30)], axis=1)
    cuff = np.c_[np.full(60, 0.45), 1.4 + along[:, 0], along[:, 1]]
    contour = Contour("cuff.left", np.arange(60), 0.3, bones=("left_elbow",))
    target = Target(cuff, np.zeros((0, 3), int), cuff, (contour,), (), "tshirt")
    garment = SimpleNamespace(contours=(contour,))
    longer = measure_contour_shapes(garment, cuff + [0.04, 0.0, 0.0], target, BODY)
    assert longer["shape.cuff.left_mm"] == pytest.approx(40.0, rel=0.05)


def test_a_contour_that_cannot_be_trusted_is_not_compared() -> None:
    """Breaks where a torn hem makes a pattern doubtful."""
    assert compare(neck(V, CREW), neck(V, CREW), trusted=False) == {}


def test_patterns_beyond_human_measures_are_told() -> None:
    """Breaks where centimetres taken for metres pass, or one of the library's own base patterns does not."""
    for name, cut in CUTS.items():
        assert measure_plausibility(draft_cut(cut, name=name))["pattern.beyond_human"] < 1.0
    shirt = load_template("tshirt")
    doll, giant = (shirt.with_points(scale * shirt.points) for scale in (0.2, 10.0))
    assert verdicts(measure_plausibility(doll))["plausible"] == "fail"
    assert verdicts(measure_plausibility(giant))["plausible"] != "pass"
