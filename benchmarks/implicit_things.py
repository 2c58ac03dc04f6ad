"""Solid things made of blended capsules and boxes, as scans of them would be: chairs, animals, rooms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from garmentq.core.geometry.geometry import vertex_normals

Mesh = tuple[np.ndarray, np.ndarray]

STEP = 0.012
"""Edge of the grid that a surface is taken from [m]: about the spacing of a cheap scanner."""

BLEND = 0.02
"""Radius over which pieces flow into each other [m], as a fused scan rounds every corner."""

NOISE = 0.001
"""Standard deviation of the noise along the normals [m]."""


@dataclass(frozen=True)
class Capsule:
    """Join two points [m] by a tube whose radius [m] goes from one value to another."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    end_radius: float | None = None

    @property
    def bounds(self) -> np.ndarray:
        """Return the corners of its box [m], shape [2, 3]."""
        ends = np.array([self.start, self.end])
        reach = max(self.radius, self.end_radius or 0.0)
        return np.stack([ends.min(axis=0) - reach, ends.max(axis=0) + reach])

    def measure(self, points: np.ndarray) -> np.ndarray:
        """Return the distance of points, shape [n, 3], to its surface, negative inside [m]."""
        start, along = np.array(self.start), np.subtract(self.end, self.start)
        share = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        last = self.radius if self.end_radius is None else self.end_radius
        radius = self.radius + share * (last - self.radius)
        return np.asarray(np.linalg.norm(points - start - share[:, None] * along, axis=1) - radius)


@dataclass(frozen=True)
class Box:
    """Stand a box with rounded edges at a centre [m]; sizes [m]."""

    centre: tuple[float, float, float]
    size: tuple[float, float, float]

    @property
    def bounds(self) -> np.ndarray:
        """Return its corners [m], shape [2, 3]."""
        half = np.multiply(0.5, self.size)
        return np.stack([np.subtract(self.centre, half), np.add(self.centre, half)])

    def measure(self, points: np.ndarray) -> np.ndarray:
        """Return the distance of points, shape [n, 3], to its surface, negative inside [m]."""
        beyond = np.abs(points - np.array(self.centre)) - 0.5 * np.array(self.size)
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        return np.asarray(outside + np.minimum(beyond.max(axis=1), 0.0))


Piece = Capsule | Box


def make_surface(pieces: Sequence[Piece], seed: int, step: float = STEP) -> Mesh:
    """Return the noisy surface of blended pieces, positions [m] and faces."""
    import igl

    bounds = np.array([piece.bounds for piece in pieces])
    low, high = bounds[:, 0].min(axis=0) - 3 * step, bounds[:, 1].max(axis=0) + 3 * step
    count = np.ceil((high - low) / step).astype(int) + 1
    axes = [low[k] + step * np.arange(count[k]) for k in range(3)]
    field = np.full(tuple(count), 1.0)
    for piece in pieces:
        near = [slice(*np.searchsorted(axes[k], piece.bounds[:, k] + [-5 * step, 5 * step])) for k in range(3)]
        grid = np.stack(np.meshgrid(*(axes[k][near[k]] for k in range(3)), indexing="ij"), axis=-1)
        inside = tuple(near)
        found = piece.measure(grid.reshape(-1, 3)).reshape(grid.shape[:3])
        field[inside] = _blend(field[inside], found)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
    values = np.ascontiguousarray(field.transpose(2, 1, 0).ravel())
    vertices, faces, *_ = igl.marching_cubes(values, np.ascontiguousarray(grid), *(int(n) for n in count), 0.0)
    vertices, faces = np.array(vertices), np.array(faces, dtype=np.int64)
    noise = np.random.default_rng(seed).normal(0.0, NOISE, len(vertices))
    return vertices + noise[:, None] * vertex_normals(vertices, faces), faces


def _blend(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the smooth minimum of two distances: the polynomial of degree 2 over `BLEND`."""
    mix = np.clip(0.5 + 0.5 * (second - first) / BLEND, 0.0, 1.0)
    return np.asarray(second + mix * (first - second) - BLEND * mix * (1.0 - mix))


def make_chair(width: float, seat: float, back: float, leg: float, arms: bool = False) -> list[Piece]:
    """Return a chair: width and depth, heights of seat and back, thickness of a leg [m]."""
    half = 0.5 * width - leg
    corners = [(x, z) for x in (-half, half) for z in (-half, half)]
    pieces: list[Piece] = [Capsule((x, 0.0, z), (x, seat, z), leg) for x, z in corners]
    pieces.append(Box((0.0, seat, 0.0), (width, 0.05, width)))
    if back > seat:
        pieces += [Capsule((x, seat, -half), (x, back, -half - 0.06), leg) for x in (-half, half)]
        pieces += [Box((0.0, back - 0.5 * (back - seat) / 2, -half - 0.04), (width, 0.5 * (back - seat), 0.04))]
    if arms:
        pieces += [Capsule((x, seat + 0.22, -half), (x, seat + 0.22, half), 0.03) for x in (-half, half)]
        pieces += [Capsule((x, seat, half), (x, seat + 0.22, half), 0.025) for x in (-half, half)]
    return pieces


def make_office_chair() -> list[Piece]:
    """Return a chair on a column with five feet."""
    angles = 2.0 * np.pi * np.arange(5) / 5
    feet = [Capsule((0.0, 0.08, 0.0), (0.32 * float(np.sin(a)), 0.05, 0.32 * float(np.cos(a))), 0.03) for a in angles]
    column = Capsule((0.0, 0.08, 0.0), (0.0, 0.45, 0.0), 0.035)
    back = Box((0.0, 0.85, -0.24), (0.44, 0.6, 0.06))
    return [
        *feet,
        column,
        Box((0.0, 0.48, 0.0), (0.48, 0.08, 0.46)),
        back,
        Capsule((0, 0.45, -0.2), (0, 0.7, -0.26), 0.03),
    ]


def make_armchair() -> list[Piece]:
    """Return a stuffed chair that stands on the floor."""
    sides = [Box((x, 0.3, 0.0), (0.16, 0.6, 0.75)) for x in (-0.38, 0.38)]
    return [Box((0.0, 0.22, 0.0), (0.7, 0.44, 0.75)), Box((0.0, 0.5, -0.33), (0.85, 1.0, 0.18)), *sides]


def make_animal(length: float, leg: float, girth: float, neck: float, head: float, tail: float = 0.3) -> list[Piece]:
    """Return an animal on four legs: lengths of trunk, legs, neck, head and tail, radius of the trunk [m]."""
    half, back = 0.5 * length, leg + girth
    pieces: list[Piece] = [Capsule((0.0, back, -half), (0.0, back + 0.05 * length, half), girth, 0.9 * girth)]
    for x in (-0.6 * girth, 0.6 * girth):
        for z in (-half, half):
            knee = (x, 0.5 * leg, z + (0.06 * leg if z > 0 else -0.08 * leg))
            pieces += [Capsule((x, back, z), knee, 0.45 * girth, 0.22 * girth), Capsule(knee, (x, 0.0, z), 0.2 * girth)]
    top = (0.0, back + 0.8 * neck, half + 0.6 * neck)
    pieces.append(Capsule((0.0, back, half), top, 0.6 * girth, 0.4 * girth))
    pieces.append(Capsule(top, (0.0, top[1] - 0.3 * head, top[2] + head), 0.42 * girth, 0.22 * girth))
    pieces += [
        Capsule((x, top[1], top[2]), (1.5 * x, top[1] + 0.5 * head, top[2]), 0.1 * girth)
        for x in (-0.25 * girth, 0.25 * girth)
    ]
    end = (0.0, back - 0.7 * tail, -half - girth - 0.5 * tail)
    pieces.append(Capsule((0.0, back, -half), end, 0.2 * girth, 0.1 * girth))
    return pieces


def make_room(width: float, depth: float, things: Sequence[tuple[float, float, Sequence[Piece]]]) -> list[Piece]:
    """Return a room with a floor and two walls, and things that stand at places x, z [m] in it."""
    pieces: list[Piece] = [
        Box((0.0, -0.05, 0.0), (width, 0.1, depth)),
        Box((-0.5 * width, 1.2, 0.0), (0.1, 2.5, depth)),
        Box((0.0, 1.2, -0.5 * depth), (width, 2.5, 0.1)),
    ]
    return pieces + [shift_piece(piece, x, z) for x, z, thing in things for piece in thing]


def shift_piece(piece: Piece, x: float, z: float) -> Piece:
    """Return a piece moved along the floor [m]."""
    if isinstance(piece, Box):
        return Box((piece.centre[0] + x, piece.centre[1], piece.centre[2] + z), piece.size)
    start, end = ((p[0] + x, p[1], p[2] + z) for p in (piece.start, piece.end))
    return Capsule(start, end, piece.radius, piece.end_radius)


def make_table(width: float, height: float) -> list[Piece]:
    """Return a table on four legs [m]."""
    half = 0.5 * width - 0.06
    legs: list[Piece] = [Capsule((x, 0.0, z), (x, height, z), 0.03) for x in (-half, half) for z in (-half, half)]
    return [*legs, Box((0.0, height, 0.0), (width, 0.05, width))]


def make_lamp() -> list[Piece]:
    """Return a lamp as tall as a person."""
    return [
        Capsule((0, 0.02, 0), (0, 0.04, 0), 0.16),
        Capsule((0, 0, 0), (0, 1.5, 0), 0.02),
        Box((0, 1.6, 0), (0.4, 0.3, 0.4)),
    ]


CHAIRS = {
    "kitchen chair": make_chair(0.42, 0.46, 0.95, 0.02),
    "chair with arms": make_chair(0.55, 0.45, 0.90, 0.025, arms=True),
    "bar chair": make_chair(0.40, 0.76, 1.15, 0.02),
    "stool": make_chair(0.36, 0.46, 0.0, 0.022),
    "office chair": make_office_chair(),
    "armchair": make_armchair(),
}

ANIMALS = {
    "dog": make_animal(0.55, 0.35, 0.13, 0.20, 0.22),
    "cat": make_animal(0.32, 0.16, 0.07, 0.09, 0.10, 0.25),
    "sheep": make_animal(0.80, 0.35, 0.26, 0.28, 0.25, 0.15),
    "horse": make_animal(1.35, 0.85, 0.30, 0.75, 0.55, 0.6),
    "cow": make_animal(1.50, 0.70, 0.38, 0.45, 0.50, 0.7),
    "giraffe": make_animal(1.20, 1.50, 0.36, 1.90, 0.55, 0.7),
}

ROOMS = {
    "dining room": make_room(
        3.0,
        3.0,
        [(0, 0, make_table(1.0, 0.74)), *((x, z, CHAIRS["kitchen chair"]) for x, z in ((0.9, 0), (-0.9, 0), (0, 0.9)))],
    ),
    "living room": make_room(
        3.5,
        3.0,
        [
            (0.5, -0.9, make_armchair()),
            (-1.0, -0.9, make_armchair()),
            (0, 0.5, make_table(0.8, 0.4)),
            (1.3, -1.1, make_lamp()),
        ],
    ),
    "office": make_room(2.5, 2.5, [(0, -0.5, make_table(1.2, 0.74)), (0, 0.4, make_office_chair())]),
}
