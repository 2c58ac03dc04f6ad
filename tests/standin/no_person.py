"""What a scanner may see that is no whole person: furniture, animals, rooms, halves of persons, and two persons."""

from __future__ import annotations

import numpy as np
import trimesh
from dressed_person import Dressed, dress_person
from garmentq.core.body.template import Template

Mesh = tuple[np.ndarray, np.ndarray]
"""Vertices [m], y up, shape [n, 3], and faces, shape [f, 3]."""

CUTS = ("upper", "lower", "left")
"""Halves that a person can be cut to."""


def make_chair(seed: int) -> Mesh:
    """Build a chair: seat, legs and back, in every second one arms too; 0.8 to 1.2 m high."""
    rng = np.random.default_rng(seed)
    width, depth, seat = rng.uniform(0.38, 0.6), rng.uniform(0.38, 0.6), rng.uniform(0.4, 0.5)
    back, leg = rng.uniform(0.4, 0.7), rng.uniform(0.03, 0.06)
    boxes = [_box((width, 0.05, depth), (0, seat, 0)), _box((width, back, 0.04), (0, seat + back / 2, -depth / 2))]
    for x in (-1, 1):
        for z in (-1, 1):
            boxes.append(_box((leg, seat, leg), (x * (width - leg) / 2, seat / 2, z * (depth - leg) / 2)))
        if seed % 2:
            boxes.append(_box((0.05, 0.04, depth), (x * width / 2, seat + 0.22, 0)))
            boxes.append(_box((0.04, 0.22, 0.04), (x * width / 2, seat + 0.11, depth / 2 - 0.05)))
    return _join(boxes, rng)


def make_quadruped(seed: int) -> Mesh:
    """Build an animal on four legs: trunk, neck, head, tail; 0.9 to 1.7 m high."""
    rng = np.random.default_rng(seed)
    leg, length, girth = rng.uniform(0.45, 0.8), rng.uniform(0.6, 1.2), rng.uniform(0.12, 0.25)
    rise = rng.uniform(0.2, 0.6)
    trunk = leg + girth * 0.8
    head = (0.0, trunk + rise, length / 2 + rng.uniform(0.15, 0.35))
    parts = [_capsule((0, trunk, -length / 2), (0, trunk, length / 2), girth)]
    parts.append(_capsule((0, trunk, length / 2), head, girth * 0.45))
    parts.append(_capsule(head, (0, head[1] - 0.05, head[2] + 0.25), girth * 0.5))
    parts.append(_capsule((0, trunk, -length / 2), (0, trunk - 0.2, -length / 2 - 0.3), 0.03))
    for x in (-1, 1):
        for z in (-1, 1):
            foot = (x * girth * 0.6, 0.03, z * length / 2 + rng.uniform(-0.1, 0.1))
            parts.append(_capsule((x * girth * 0.6, trunk, z * length / 2), foot, rng.uniform(0.04, 0.07)))
    return _join(parts, rng)


def make_room(seed: int, height: float = 2.4) -> Mesh:
    """Build a furnished room: floor, two or three walls, a table, chairs, a shelf; `height` of the walls [m]."""
    rng = np.random.default_rng(seed)
    width, depth = rng.uniform(2.0, 4.0, 2)
    boxes = [_box((width, 0.02, depth), (0, 0, 0)), _box((width, height, 0.02), (0, height / 2, -depth / 2))]
    boxes.append(_box((0.02, height, depth), (-width / 2, height / 2, 0)))
    if seed % 2:
        boxes.append(_box((0.02, height, depth), (width / 2, height / 2, 0)))
    boxes.append(_box((1.2, 0.04, 0.7), (0, 0.74, 0)))
    for x, z in ((-0.55, -0.3), (-0.55, 0.3), (0.55, -0.3), (0.55, 0.3)):
        boxes.append(_box((0.05, 0.74, 0.05), (x, 0.37, z)))
    boxes.append(_box((0.8, 1.8, 0.35), (-width / 2 + 0.45, 0.9, -depth / 2 + 0.2)))
    room = _join(boxes, rng)
    chair = make_chair(seed)
    place = np.array([0.3, 0.0, 0.7])
    return np.vstack([room[0], chair[0] + place]), np.vstack([room[1], chair[1] + len(room[0])])


def cut_person(person: Dressed, half: str) -> Mesh:
    """Return the half of a person above or below the pelvis, or to the left of its middle."""
    centre = person.joints[0]
    if half == "left":
        aside = np.array([np.cos(person.heading), 0.0, -np.sin(person.heading)])
        kept = (person.vertices - centre) @ aside > 0
    else:
        kept = (person.vertices[:, 1] > centre[1]) == (half == "upper")
    return keep_vertices(person.vertices, person.faces, kept)


def pair_persons(template: Template, seed: int, gap: float) -> Mesh:
    """Put two persons side by side, with a gap between them [m]; at 0 they touch, below they overlap."""
    outfits = ("tee and shorts", "shirt and trousers", "skirt", "tight")
    stances = ("down", "A", "stride")
    first = dress_person(template, 2 * seed, stances[seed % 3], outfits[seed % 4])
    other = dress_person(template, 2 * seed + 1, stances[(seed + 1) % 3], outfits[(seed + 2) % 4])
    shift = first.vertices.max(axis=0) - other.vertices.min(axis=0)
    shift[0] += gap
    shift[1] = first.vertices[:, 1].min() - other.vertices[:, 1].min()
    shift[2] = first.joints[0, 2] - other.joints[0, 2]
    vertices = np.vstack([first.vertices, other.vertices + shift])
    return vertices, np.vstack([first.faces, other.faces + len(first.vertices)])


def keep_vertices(vertices: np.ndarray, faces: np.ndarray, kept: np.ndarray) -> Mesh:
    """Return what is left of a mesh where some vertices are kept."""
    place = np.cumsum(kept) - 1
    return vertices[kept], place[faces[kept[faces].all(axis=1)]]


def _box(size: tuple[float, float, float], centre: tuple[float, float, float]) -> trimesh.Trimesh:
    return trimesh.creation.box(size, trimesh.transformations.translation_matrix(centre))


def _capsule(start: tuple[float, ...], end: tuple[float, ...], radius: float) -> trimesh.Trimesh:
    return trimesh.creation.cylinder(radius, segment=np.array([start, end]), sections=20)


def _join(parts: list[trimesh.Trimesh], rng: np.random.Generator) -> Mesh:
    """Put parts together in triangles of at most 3 cm, turned about y, with 1.5 mm of noise."""
    whole = trimesh.util.concatenate([part.subdivide_to_size(0.03) for part in parts])
    angle = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    return whole.vertices @ turn.T + rng.normal(0, 1.5e-3, whole.vertices.shape), np.asarray(whole.faces)
