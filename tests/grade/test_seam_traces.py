"""A seam is found where colours change, and where stripes turn, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.recover.grade.colour_seams import find_steps
from garmentq.core.recover.grade.seam_strips import SEARCH_STEP, SeamTrace
from garmentq.core.recover.grade.seam_traces import TraceKind, find_seam_traces
from garmentq.core.recover.grade.seen_seams import find_traced_seams
from garmentq.core.recover.grade.stripe_seams import find_turns
from garmentq.core.scan.contours.target import Target

RED, BLUE = np.array([0.7, 0.1, 0.1]), np.array([0.1, 0.2, 0.6])

NOISE = 0.05
"""Standard deviation of a camera's colours in 0..1."""


@pytest.fixture(scope="module")
def shirt() -> Garment:
    """Return a T-shirt as it hangs on the built-in body."""
    garment = load_draped_template("tshirt")
    if garment is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return garment


def refine(garment: Garment, times: int = 2) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a garment's surface with four faces for each, so many times, and the panel of each vertex."""
    nodes, faces, panel = garment.nodes, garment.faces, garment.panel_of_face
    for _ in range(times):
        a, b, c = faces.T
        edges = np.sort(np.concatenate([[a, b], [b, c], [c, a]], axis=1), axis=0)
        unique, place = np.unique(edges, axis=1, return_inverse=True)
        ab, bc, ca = (len(nodes) + place.ravel()).reshape(3, -1)
        nodes = np.concatenate([nodes, nodes[unique].mean(axis=0)])
        faces = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        panel = np.tile(panel, 4)
    of_vertex = np.zeros(len(nodes), dtype=np.int64)
    of_vertex[faces] = panel[:, None]
    return nodes, faces, of_vertex


def paint(garment: Garment, beyond: float, rng: np.random.Generator) -> Target:
    """Return a shirt's surface, its sleeves blue from a distance outwards of the armholes [m] on, else red."""
    vertices, faces, panel = refine(garment)
    is_sleeve = np.array(["sleeve" in one.name for one in garment.pattern.panels])
    body = TriangleSurface(garment.nodes, garment.faces[~is_sleeve[garment.panel_of_face]])
    blue = is_sleeve[panel] & (body.distance(vertices) > beyond)
    colours = np.where(blue[:, None], BLUE, RED) + NOISE * rng.normal(size=(len(vertices), 3))
    normals = vertex_normals(vertices, faces)
    return Target(vertices, faces, normals, (), (), "tshirt", colours=np.clip(colours, 0.0, 1.0))


def find_armholes(garment: Garment, target: Target, kind: TraceKind) -> list[SeamTrace]:
    """Return the traces of both armholes, and check that these are the only ones, and of one kind."""
    found = find_seam_traces(garment, target)
    assert {(line.name, line.side) for line in found} == {("armhole seam", side) for side in ("left", "right")}
    assert {one for one, _ in found.values()} == {kind}
    return [trace for _, trace in found.values()]


@pytest.mark.parametrize("beyond", [0.0, 0.015])
def test_armholes_are_where_the_colours_change(shirt: Garment, beyond: float) -> None:
    """Breaks where a seam between two colours is not found, found beside it, or found at another seam too."""
    target = paint(shirt, beyond, np.random.default_rng(3))
    steps = find_armholes(shirt, target, TraceKind.COLOUR)
    is_sleeve = np.array(["sleeve" in one.name for one in shirt.pattern.panels])
    body = TriangleSurface(shirt.nodes, shirt.faces[~is_sleeve[shirt.panel_of_face]])
    for step in steps:
        off = body.distance(step.places) - beyond
        assert np.median(np.abs(off)) < 0.004 and step.is_at(shirt.nodes, 0.01) == (beyond == 0.0)
    seams = find_traced_seams(shirt, target)
    apart = np.concatenate([seam.distance(shirt.nodes) for seam in seams])
    assert np.median(np.abs(apart)) == pytest.approx(beyond, abs=0.005)


def test_cloth_that_completes_a_scan_has_no_colour(shirt: Garment) -> None:
    """Breaks where a surface that another garment hides, joined to the target, is asked for its colours."""
    target = paint(shirt, 0.0, np.random.default_rng(3))
    apart = target.vertices[:60] + [0.0, -1.0, 0.0]
    added = len(target.vertices) + np.arange(60).reshape(-1, 3)
    more = replace(
        target, vertices=np.concatenate([target.vertices, apart]), faces=np.concatenate([target.faces, added])
    )
    assert find_seam_traces(shirt, more).keys() == find_seam_traces(shirt, target).keys() != set()


def test_plain_and_printed_cloth_shows_no_seam(shirt: Garment) -> None:
    """Breaks where noise, shades or a print of dots pass for a seam."""
    rng = np.random.default_rng(4)
    target = paint(shirt, 1.0, rng)
    assert find_seam_traces(shirt, target) == {}
    dots = (np.sin(target.vertices * 200.0).prod(axis=1) > 0.1)[:, None]
    assert find_seam_traces(shirt, replace(target, colours=np.where(dots, RED, BLUE))) == {}
    shades = 0.6 + 0.2 * target.normals[:, 2:]
    assert find_seam_traces(shirt, replace(target, colours=shades * RED + 0.02)) == {}
    assert find_seam_traces(shirt, replace(target, colours=None)) == {}


@pytest.mark.parametrize("blur", [0, 3])
@pytest.mark.parametrize("seed", range(3))
def test_steps_of_rows_are_found(seed: int, blur: int) -> None:
    """Breaks where a step that wanders along a seam is lost or found elsewhere, or rows without one get it."""
    rng = np.random.default_rng(seed)
    places = np.round(20 + 5 * np.sin(np.arange(40) / 8.0)).astype(int)
    places[24:] = 60
    colours = np.where((np.arange(41) < places[:, None])[:, :, None], RED, BLUE)
    kernel = np.ones(2 * blur + 1) / (2 * blur + 1)
    padded = np.pad(colours, ((0, 0), (blur, blur), (0, 0)), "edge")
    colours = np.apply_along_axis(lambda row: np.convolve(row, kernel, "valid"), 1, padded)
    colours = colours + NOISE * rng.normal(size=colours.shape)
    found, is_seen = find_steps(colours, np.ones((40, 41), dtype=bool), blur)
    assert is_seen[:22].all() and not is_seen[28:].any()
    assert np.abs(found - places + 0.5)[:20].max() <= 2.0
    assert 0.001 <= SEARCH_STEP <= 0.005


def stripe(garment: Garment, is_turned: bool, rng: np.random.Generator) -> Target:
    """Return a shirt's surface in stripes 2 cm wide, those of its sleeves turned by a right angle in the flat cloth."""
    vertices, faces, panel = refine(garment, 3)
    near = TriangleSurface(garment.nodes, garment.faces).closest(vertices)
    flat = near.interpolate(garment.uv, garment.uv_faces)
    is_sleeve = np.array(["sleeve" in one.name for one in garment.pattern.panels])[panel] & is_turned
    blue = np.floor(np.where(is_sleeve, flat[:, 0], flat[:, 1]) / 0.02).astype(int) % 2 == 1
    colours = np.where(blue[:, None], BLUE, RED) + NOISE * rng.normal(size=(len(vertices), 3))
    normals = vertex_normals(vertices, faces)
    return Target(vertices, faces, normals, (), (), "tshirt", colours=np.clip(colours, 0.0, 1.0))


def test_armholes_are_where_stripes_turn(shirt: Garment) -> None:
    """Breaks where stripes that turn at a seam are not found, or stripes that run on are taken for a seam."""
    found = find_seam_traces(shirt, stripe(shirt, True, np.random.default_rng(5)))
    armholes = [found[line] for line in found if line.name == "armhole seam"]
    assert [kind for kind, _ in armholes] == [TraceKind.STRIPES] * 2
    assert all(trace.is_at(shirt.nodes, 0.008) for _, trace in armholes)
    plain = find_seam_traces(shirt, stripe(shirt, False, np.random.default_rng(5)))
    assert all(trace.is_at(shirt.nodes, 0.01) for _, trace in plain.values())
    assert "side seam" not in {line.name for line in plain}


@pytest.mark.parametrize("seed", range(3))
def test_turns_of_rows_are_found(seed: int) -> None:
    """Breaks where stripes that turn by 30 degrees are lost, and where those that turn all the way are taken for it."""
    rng = np.random.default_rng(seed)
    columns, rows = np.arange(41), np.arange(30)
    place = np.round(20 + 6 * np.sin(rows / 8.0))
    slowly = 0.04 * rows[:, None] + 0.1 * rng.normal(size=(30, 41))

    def as_directions(angle: np.ndarray) -> np.ndarray:
        return np.stack([np.cos(2.0 * angle), np.sin(2.0 * angle)], axis=2)

    turned = slowly + np.radians(30.0) * (columns >= place[:, None])
    found, is_seen = find_turns(as_directions(turned), np.ones((30, 41)))
    assert is_seen.all() and np.abs(found - place + 0.5).max() <= 2.0
    assert not find_turns(as_directions(slowly), np.ones((30, 41)))[1].any()
    assert not find_turns(as_directions(slowly + np.radians(60.0) * columns / 40.0), np.ones((30, 41)))[1].any()
