"""Corners that a scan proves: skirts rolled on a cone, whose flat hems are known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from garmentq.core.garment.fairness import unplanned_corners
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.judge.fairness import measure_fairness
from garmentq.core.recover.fit.fairness import fair_garment
from garmentq.core.recover.fit.locks import find_locked_coordinates
from garmentq.core.recover.fit.rim_corners import prove_corners
from garmentq.core.scan.contours.target import Contour, Target

HALF = np.radians(10.0)
"""Half of the angle at which a panel's side seams meet: a straight hem turns by twice that at each side seam."""

UPPER, LOWER = 0.9, 1.5
"""Distance of waist and hem from there [m]."""


def make_skirt(half: float, curved: bool = False) -> Pattern:
    """Return a skirt of two equal panels whose side seams lean by `half` [rad]; hem and waist straight, or arcs."""
    ends = [(LOWER, -half), (LOWER, half), (UPPER, half), (UPPER, -half)]
    if half == 0.0:
        points = np.array([(-0.25, -LOWER), (0.25, -LOWER), (0.25, -UPPER), (-0.25, -UPPER)])
    else:
        points = np.array([(r * np.tan(a), -r) for r, a in ends])
        if curved:
            points = np.array([(r * np.sin(a), -r * np.cos(a)) for r, a in ends])
    bow = 0.5 * np.tan(half / 2.0)  # of an arc that sweeps twice the half angle, in chords
    hem = Edge("arc", np.array([(0.5, -bow)])) if curved else Edge()
    waist = Edge("arc", np.array([(0.5, bow)])) if curved else Edge()
    panels = tuple(Panel(name, points, (hem, Edge(), waist, Edge())) for name in ("front", "back"))
    seams = (Seam(EdgeRef("front", 1), EdgeRef("back", 3)), Seam(EdgeRef("front", 3), EdgeRef("back", 1)))
    return Pattern("skirt", panels, seams)


@cache
def roll(half: float, count: int, curved: bool = False) -> Garment:
    """Return a skirt's mesh rolled on the cone that its panels are part of, hem named."""
    pattern = make_skirt(half, curved)
    garment = mesh_pattern(pattern, count)
    flat = garment.uv
    radius, way = np.hypot(*flat.T), np.arctan2(flat[:, 0], -flat[:, 1])
    way = np.where(garment.panel_of_uv == 0, way, way + 2.0 * half) * (2.0 * np.pi / (4.0 * half))
    slope = 4.0 * half / (2.0 * np.pi)  # sine of the cone's half angle
    rolled = radius[:, None] * np.stack(
        [slope * np.sin(way), -np.full_like(way, np.sqrt(1.0 - slope**2)), slope * np.cos(way)], axis=1
    )
    nodes = np.zeros((len(garment.nodes), 3))
    nodes[garment.uv_node] = rolled
    return garment.at(nodes, (Contour("hem", _lowest_loop(nodes, garment.faces), 1.0),))


def as_target(garment: Garment, noise: float = 0.0, seed: int = 0) -> Target:
    """Return a rolled skirt as a scan with Gaussian noise [m per coordinate]."""
    nodes = garment.nodes + np.random.default_rng(seed).normal(0.0, 1.0, garment.nodes.shape) * noise
    normals = vertex_normals(nodes, garment.faces)
    return Target(nodes, garment.faces, normals, garment.contours, (), "skirt")


def _lowest_loop(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    edges = HalfEdges.of(faces, len(nodes))
    after = dict(zip(edges.tail[edges.border].tolist(), edges.head[edges.border].tolist(), strict=True))
    loop = [min(after, key=lambda node: nodes[node, 1])]
    while (node := after[loop[-1]]) != loop[0]:
        loop.append(node)
    return np.array(loop)


def test_a_corner_of_the_hem_is_measured_and_kept() -> None:
    """Fails if a rim's turning were not that of its flat outline, the corner were taken away, or counted as a fault."""
    base, true = make_skirt(0.0), make_skirt(HALF)
    recovered, scan = roll(HALF, 900), as_target(roll(HALF, 2500))
    corners = prove_corners(recovered, recovered.nodes, scan, base)
    assert len(corners) == 2
    assert all(corner.contour == "hem" for corner in corners)
    assert np.degrees([corner.angle for corner in corners]) == pytest.approx([20.0, 20.0], abs=0.5)
    assert "20." in corners[0].describe().message or "19." in corners[0].describe().message
    proved = {corner.join: corner.angle for corner in corners}
    held = find_locked_coordinates(true, base, ())
    kept = fair_garment(recovered, base, held, corners).pattern
    faired = fair_garment(recovered, base, held).pattern
    assert np.degrees(unplanned_corners(kept, base, proved)) == pytest.approx(0.0, abs=2.6)
    assert {kept.panel(name).edges[0].kind for name in ("front", "back")} == {"line"}
    assert {faired.panel(name).edges[0].kind for name in ("front", "back")} == {"cubic"}
    measured = measure_fairness(kept, base, dict.fromkeys(proved, 2.0 * HALF))
    assert measured["pattern.corner_deg"] < 5.0
    assert measured["pattern.proved_corner_deg"] == pytest.approx(20.0)


def test_a_corner_that_the_fit_missed_is_given() -> None:
    """Fails if the scan's corner were only kept where the fitted pattern happens to have it."""
    base, true = make_skirt(0.0), make_skirt(HALF)
    recovered, scan = roll(HALF, 900), as_target(roll(HALF, 2500))
    corners = prove_corners(recovered, recovered.nodes, scan, base)
    smooth = fair_garment(recovered, base, find_locked_coordinates(true, base, ()))
    given = fair_garment(smooth, base, find_locked_coordinates(true, base, ()), corners).pattern
    proved = {corner.join: corner.angle for corner in corners}
    assert np.degrees(np.abs(unplanned_corners(given, base, proved))).max() < 2.6


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("noise", [0.0, 0.0005, 0.002])
def test_a_smooth_hem_stays_smooth(noise: float, seed: int) -> None:
    """Fails if noise, or how a round hem curves, were taken for a corner."""
    base, recovered = make_skirt(0.0), roll(HALF, 900, curved=True)
    scan = as_target(roll(HALF, 2500, curved=True), noise, seed)
    assert prove_corners(recovered, recovered.nodes, scan, base) == ()


def test_what_is_not_trusted_proves_nothing() -> None:
    """Fails if a cut-off hem's corner got into the pattern."""
    base = make_skirt(0.0)
    recovered, scan = roll(HALF, 900), as_target(roll(HALF, 2500))
    for change in ({"trusted": False}, {"hidden": True}):
        contours = tuple(replace(contour, **change) for contour in scan.contours)
        assert prove_corners(recovered, recovered.nodes, replace(scan, contours=contours), base) == ()
