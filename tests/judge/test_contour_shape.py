"""Wrong parts show in the shape of a drape's open contours, and right ones do not."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.parts.draft import draft_cut
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.curves import Curve
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.judge.contour_shape import measure_contour_shapes
from garmentq.core.judge.gates import evaluate_gates
from garmentq.core.judge.plausibility import measure_plausibility
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import Contour, Target
from standing_gores import stand_gores

BODY = builtin_body("builtin:female,height=1.70")


@cache
def sewn(name: str) -> Garment:
    """Return a base pattern, meshed and sewn where it is placed, with its neck named."""
    garment = mesh_pattern(load_template(name), 1000)
    neck = max(find_loops(garment.faces), key=lambda loop: garment.nodes[loop, 1].mean())
    return garment.at(garment.nodes, (Contour("neck", neck, 0.6),))


def wear(name: str) -> Target:
    """Return a target whose neck is that of a base pattern, which leans before and behind the neck."""
    garment = sewn(name)
    loop = garment.nodes[garment.contours[0].vertices]
    top = loop[:, 1].max()
    places = np.c_[loop[:, :2], 0.4 * (top - loop[:, 1]) * np.sign(loop[:, 2])]
    return scan_of(places, "neck")


def scan_of(points: np.ndarray, name: str, trusted: bool = True, bones: tuple[str, ...] = ()) -> Target:
    """Return a target that is one contour."""
    contour = Contour(name, np.arange(len(points)), 0.6, bones, trusted=trusted)
    return Target(points, np.zeros((0, 3), int), points, (contour,), (), "tshirt")


def compare(ours: np.ndarray, theirs: Target) -> dict[str, float | None]:
    """Compare a closed line, as a contour of a drape, with a scan's of the same name."""
    garment = SimpleNamespace(
        pattern=Pattern("none", (), ()), contours=(Contour(theirs.contours[0].name, np.arange(len(ours)), 0.6),)
    )
    return measure_contour_shapes(garment, ours, theirs, BODY)


def verdicts(metrics: dict[str, float | None]) -> dict[str, str]:
    """Judge metrics, by gate."""
    return {gate.name: str(gate.verdict) for gate in evaluate_gates(metrics)}


NECKLINES = {
    "crew": "tshirt",
    "v": "tshirt+neckline=v",
    "back v": "tshirt+back_neckline=v",
    "boat": "tshirt+neckline=boat",
}


@pytest.mark.parametrize("cut", NECKLINES)
@pytest.mark.parametrize("scan", NECKLINES)
def test_a_neckline_of_another_kind_does_not_pass(cut: str, scan: str) -> None:
    """Breaks where a crew neck cut for a V passes, in front or behind, or a neckline cut as it is worn does not."""
    garment = sewn(NECKLINES[cut])
    found = measure_contour_shapes(garment, garment.nodes, wear(NECKLINES[scan]), BODY)
    cut_v, scan_v = ({side for side in ("v", "back v") if side == kind} for kind in (cut, scan))
    assert verdicts(found)["neckline"] == ("pass" if cut_v == scan_v else "fail")


@pytest.mark.parametrize("aside", [-0.010, 0.0, 0.010])
def test_a_v_may_hang_aside(aside: float) -> None:
    """Breaks where the pattern's corner is looked for in the middle of the drape alone."""
    target, garment = wear("tshirt+neckline=v"), sewn("tshirt+neckline=v")
    nodes = garment.nodes.copy()
    down = nodes[:, 1].max() - nodes[:, 1]
    nodes[:, 0] += np.where(nodes[:, 2] > 0, aside * np.minimum(1.0, down / 0.1), 0.0)
    found = measure_contour_shapes(garment, nodes, target, BODY)
    assert verdicts(found)["neckline"] == "pass"


def test_a_v_may_hang_bowed() -> None:
    """Breaks where the bow of worn cloth is taken for another cut: it opens the corner in space, not in the flat."""
    target, garment = wear("tshirt+neckline=v"), sewn("tshirt+neckline=v")
    bowed = target.vertices.copy()
    front = bowed[:, 2] > 0
    bowed[front, 1] -= 0.015 * np.sin(np.pi * np.abs(bowed[front, 0]) / np.abs(bowed[front, 0]).max())
    found = measure_contour_shapes(garment, garment.nodes, scan_of(bowed, "neck"), BODY)
    assert verdicts(found)["neckline"] == "pass"


def test_the_distance_of_necklines_is_measured_in_the_cloth() -> None:
    """Breaks where a drape that hangs lower is charged for it: only the unrolled lines count."""
    garment, target = sewn("tshirt+neckline=v"), wear("tshirt+neckline=v")
    nodes = garment.nodes.copy()
    nodes[garment.contours[0].vertices] = target.vertices + [0.0, -0.03, 0.01]
    assert measure_contour_shapes(garment, nodes, target, BODY)["shape.neck_mm"] == pytest.approx(0.0, abs=0.5)
    nodes[:, 1] -= 0.03 * (nodes[:, 2] > 0) * (1.0 - np.abs(nodes[:, 0]) / 0.09).clip(0.0)  # the front is deeper
    assert 15.0 < measure_contour_shapes(garment, nodes, target, BODY)["shape.neck_mm"] < 35.0


def ring(height, radius: float = 0.2, folds: int = 0) -> np.ndarray:
    """Return a closed line around the y axis; `height` is a function of the angle."""
    angle = np.linspace(0.0, 2 * np.pi, 240, endpoint=False)
    wide = radius + 0.02 * np.sin(folds * angle)
    return np.stack([wide * np.sin(angle), height(angle), wide * np.cos(angle)], axis=1)


def test_folds_of_a_hem_do_not_count_and_its_dip_does() -> None:
    """Breaks where folds that fall elsewhere are a wrong part, or a tail at the back is averaged away."""
    level = ring(lambda a: 0.5 + 0.0 * a)
    folded = ring(lambda a: 0.5 + 0.008 * np.sin(9 * a), folds=9)
    assert compare(folded, scan_of(level, "hem"))["shape.hem_mm"] < 3.0
    tail = ring(lambda a: 0.5 - 0.05 * np.cos(a))
    assert compare(tail, scan_of(level, "hem"))["shape.hem_mm"] == pytest.approx(50.0, abs=8.0)


def test_a_cuff_is_measured_along_the_arm() -> None:
    """Breaks where a sleeve's length is measured downwards: the built-in body stretches its arms out."""
    along = np.stack([0.05 * np.cos(np.arange(60) * np.pi / 30), 0.05 * np.sin(np.arange(60) * np.pi / 30)], axis=1)
    cuff = np.c_[np.full(60, 0.45), 1.4 + along[:, 0], along[:, 1]]
    longer = compare(cuff + [0.04, 0.0, 0.0], scan_of(cuff, "cuff.left", bones=("left_elbow",)))
    assert longer["shape.cuff.left_mm"] == pytest.approx(40.0, rel=0.05)


def test_a_contour_that_cannot_be_trusted_is_not_compared() -> None:
    """Breaks where a torn hem makes a pattern doubtful."""
    hem = ring(lambda a: 0.5 + 0.0 * a)
    assert compare(hem, scan_of(hem, "hem", trusted=False)) == {}


def test_patterns_beyond_human_measures_are_told() -> None:
    """Breaks where centimetres taken for metres pass, or one of the library's own base patterns does not."""
    for name, cut in CUTS.items():
        assert measure_plausibility(draft_cut(cut, name=name))["pattern.beyond_human"] < 1.0
    shirt = load_template("tshirt")
    doll, giant = (shirt.with_points(scale * shirt.points) for scale in (0.2, 10.0))
    assert verdicts(measure_plausibility(doll))["plausible"] == "fail"
    assert verdicts(measure_plausibility(giant))["plausible"] != "pass"


GORE = np.array([[0.0, 0.0], [0.5, 0.0], [0.31, 0.5], [0.19, 0.5]])
"""A gore with a straight hem [m]: its sides stand out by 20.8 degrees, so that a hem turns by 41.6 at each seam."""
GORES = 8


def sew_gores() -> tuple[Garment, np.ndarray]:
    """Return a skirt of gores and where its nodes are as it stands."""
    panels = tuple(Panel(f"gore_{k}", GORE, tuple(Edge() for _ in GORE)) for k in range(GORES))
    seams = tuple(Seam(EdgeRef(f"gore_{k}", 1), EdgeRef(f"gore_{(k + 1) % GORES}", 3)) for k in range(GORES))
    garment = mesh_pattern(Pattern("gores", panels, seams, symmetric=False), 2000)
    return garment, stand_gores(garment)


def hem_of(garment: Garment, nodes: np.ndarray) -> np.ndarray:
    """Return the longer one of a skirt's two edges."""
    return max(find_loops(garment.faces), key=lambda loop: np.linalg.norm(np.diff(nodes[loop], axis=0), axis=1).sum())


@pytest.mark.parametrize(
    ("cut", "noise", "expected"), [("gores", 0.0, "pass"), ("circle", 0.0, "doubtful"), ("circle", 0.003, None)]
)
def test_a_circle_cut_for_gores_does_not_pass(cut: str, noise: float, expected: str | None) -> None:
    """Breaks where the corners of a hem are not looked for in the pattern, or noise is taken for them."""
    gored, places = sew_gores()
    hem = Contour("hem", hem_of(gored, places), 4.0)
    seen = places + noise * np.random.default_rng(0).standard_normal(places.shape)
    target = Target(seen, gored.faces, vertex_normals(seen, gored.faces), (hem,), (), "skirt")
    garment, nodes = gored.at(places, (hem,)), places
    if cut == "circle":
        circle = mesh_pattern(load_template("skirt+skirt=full-circle"), 1500)
        loop = hem_of(circle, circle.nodes)
        nodes = circle.nodes.copy()
        nodes[loop] = Curve(places[hem.vertices]).at_shares(np.arange(len(loop)) / len(loop))
        garment = circle.at(nodes, (Contour("hem", loop, 4.0),))
    found = measure_contour_shapes(garment, nodes, target, BODY)
    assert verdicts(found).get("edge_corners") == expected
    if expected == "doubtful":
        assert found["shape.edge_corner_deg"] == pytest.approx(39.2, abs=1.5)  # the circle itself turns by 2.4
