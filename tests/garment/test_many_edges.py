"""Patterns of as many edges as are read: what is found is what a slow search finds, and it does not take long."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.garmentcode import MAX_EDGES
from garmentq.core.garment.meshing import points_in_polygon
from garmentq.core.garment.mirrors import FLAT_TOLERANCE, HANDLE_TOLERANCE, PLACE_TOLERANCE, find_mirrors
from garmentq.core.garment.orientation import place_points
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.validity import find_crossing
from garmentq.service import patterns
from garmentq.service.patterns import examine_pattern

CURVES = ({}, {"curvature": {"type": "cubic", "params": [[0.3, 0.1], [0.7, 0.1]]}})


def draw_circle(count: int, more: dict) -> dict:
    """Return a document of one round panel, 60 cm wide."""
    angle = 2.0 * np.pi * np.arange(count) / count
    vertices = 30.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    edges = [{"endpoints": [i, (i + 1) % count], **more} for i in range(count)]
    return {
        "pattern": {"panels": {"front": {"vertices": vertices.tolist(), "edges": edges}}, "stitches": []},
        "properties": {"units_in_meter": 100},
    }


@pytest.mark.parametrize("more", [CURVES[0], pytest.param(CURVES[1], marks=pytest.mark.nightly)], ids=["line", "curve"])
def test_most_edges_are_examined_within_the_bounds(tmp_path, monkeypatch, more):
    """Broken where a search compares edges pair by pair in Python: 20 s of CPU are then not enough."""
    monkeypatch.setattr(patterns, "BOUNDS", replace(patterns.BOUNDS, wall_seconds=3600.0))  # of others' work beside it
    path = tmp_path / "pattern.json"
    path.write_text(json.dumps(draw_circle(MAX_EDGES, more)))
    found = examine_pattern(path)
    assert found["is_sound"] and len(found["mirrors"]) == 1


def make_pattern(rng: np.random.Generator) -> Pattern:
    """Return panels of few shapes with noise, some turned or mirrored, some curved, sewn and placed at random."""
    panels: list[Panel] = []
    noise, is_placed = rng.choice([0.0, 1e-3, 4e-3]), rng.random() < 0.5
    for number in range(6):
        count = int(rng.choice([3, 4, 4, 6]))
        angle = 2.0 * np.pi * np.arange(count) / count
        points = np.stack([np.cos(angle), rng.choice([0.5, 1.0]) * np.sin(angle)], axis=1)
        points = (points + noise * rng.normal(size=(count, 2))) * [rng.choice([-1.0, 1.0]), 1.0]
        handle = np.array([[0.5, 0.1 + rng.choice([0.0, 0.004, 0.02])]])
        curves = [Edge("quadratic", handle) if rng.random() < 0.4 else Edge() for _ in range(count)]
        place = 2.0 * rng.choice([-1.0, 0.0, 1.0], 3) if is_placed else np.zeros(3)
        panels.append(Panel(f"panel {number}", points, tuple(curves), translation=place))
    seams = [Seam(EdgeRef("panel 0", 0), EdgeRef("panel 1", 1)), Seam(EdgeRef("panel 2", 0), EdgeRef("panel 3", 2))]
    return Pattern("made up", tuple(panels), tuple(seams[: rng.integers(3)]))


def search_slowly(pattern: Pattern) -> list[tuple[int, int, int]]:
    """Find source, target and shift of each mirror, one pair of edges after the other."""
    sewn = {ref for seam in pattern.seams for ref in (seam.a, seam.b)}
    placed = [place_points(panel, panel.points) for panel in pattern.panels]
    middle = None
    if max(np.ptp([panel.translation for panel in pattern.panels], axis=0)) >= 1e-6:
        x = np.concatenate(placed)[:, 0]
        middle = (x.min() + x.max()) / 2.0
    found, taken = [], set()
    for source, a in enumerate(pattern.panels):
        fits = []
        for target, b in enumerate(pattern.panels):
            count = len(a.points)
            if source in taken or target in taken or target < source or len(b.points) != count:
                continue
            for shift in range(count):
                order = [(shift - i) % count for i in range(count)]
                pairs = [(order[i] - 1, i) for i in range(count)]
                if all(is_like(a, i % count, b, j, sewn) for i, j in pairs):
                    fits += rate(
                        a.points[order], b.points, placed[source][order], placed[target], middle, target, shift
                    )
        if fits:
            _, target, shift = min(fits)
            taken |= {source, target}
            found.append((source, target, shift))
    return found


def is_like(a: Panel, i: int, b: Panel, j: int, sewn: set[EdgeRef]) -> bool:
    """Return whether an edge is another's mirror image."""
    one, two = a.edges[i], b.edges[j]
    if one.kind != two.kind or (EdgeRef(a.name, i) in sewn) != (EdgeRef(b.name, j) in sewn):
        return False
    image = one.handles[::-1] * [-1.0, 1.0] + [1.0, 0.0]
    return bool(np.all(np.abs(image - two.handles) < HANDLE_TOLERANCE))


def rate(a, b, placed_a, placed_b, middle, target, shift):
    """Return the rated fit of one shift, or nothing."""
    size = np.linalg.norm(np.ptp(a, axis=0))
    from_a, from_b = a - a.mean(axis=0), b - b.mean(axis=0)
    left, _, right = np.linalg.svd(from_b.T @ from_a)
    turn = left @ np.diag([1.0, -np.sign(np.linalg.det(left @ right))]) @ right
    score = np.sqrt(((from_b - from_a @ turn.T) ** 2).sum(axis=1).mean()) / size
    if score > FLAT_TOLERANCE:
        return []
    if middle is not None:
        image = placed_a * [-1.0, 1.0, 1.0] + [2.0 * middle, 0.0, 0.0]
        score = np.sqrt(((image - placed_b) ** 2).sum(axis=1).mean()) / size
        if score > PLACE_TOLERANCE:
            return []
    return [(round(float(score), 9), target, shift)]


def test_mirrors_are_those_of_a_slow_search():
    """Broken where comparing many panels and shifts at once finds another pair, or another shift of it."""
    count = 0
    for seed in range(60):
        pattern = make_pattern(np.random.default_rng(seed))
        wanted = search_slowly(pattern)
        assert [(one.source, one.target, int(one.order[0])) for one in find_mirrors(pattern)] == wanted, seed
        count += len(wanted)
    assert count > 100


def test_points_and_crossings_are_those_of_a_slow_search():
    """Broken where a point as high as a corner, or a crossing of far sides, is taken for another."""
    crossed = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        polygon = rng.integers(0, 12, (int(rng.integers(3, 9)), 2)).astype(float)
        points = rng.integers(-1, 13, (200, 2)).astype(float)
        wanted = [count_left(polygon, x, y) % 2 == 1 for x, y in points]
        assert points_in_polygon(polygon, points).tolist() == wanted
        found = find_crossing(polygon)
        assert found == first_crossing(polygon)
        crossed += found is not None
    assert 5 < crossed < 40 and not len(points_in_polygon(polygon, np.zeros((0, 2))))


def count_left(polygon: np.ndarray, x: float, y: float) -> int:
    """Count the sides that a ray from a point to the right meets."""
    sides = zip(polygon.tolist(), np.roll(polygon, -1, axis=0).tolist(), strict=True)
    return sum((ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax) for (ax, ay), (bx, by) in sides)


def first_crossing(polygon: np.ndarray) -> tuple[int, int] | None:
    """Find the first two sides that cross in their insides."""

    def turn(a, b, c):
        return np.sign((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])

    count = len(polygon)
    for i in range(count - 2):
        for j in range(i + 2, count - 1 if i == 0 else count):
            a, b, c, d = (polygon[k % count] for k in (i, i + 1, j, j + 1))
            if turn(a, b, c) * turn(a, b, d) < 0 and turn(c, d, a) * turn(c, d, b) < 0:
                return i, j
    return None
