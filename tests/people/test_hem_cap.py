"""A hem that a watertight scan has capped between the legs is opened, and what has two legs keeps them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.people.hem_cap import cut_part, find_hem_cap
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.scan import Scan
from scipy.spatial import Delaunay

AROUND = 72
"""Vertices around the skirt."""
RADII = (0.24, 0.17)
"""Of the skirt to the side and forward [m]."""


@pytest.fixture(scope="module")
def body() -> Body:
    return builtin_body("builtin:female,height=1.70")


def capped_skirt(body: Body, noise: float = 0.0) -> Scan:
    """Return a straight skirt whose hem at the knees is closed but for a hole around each leg."""
    knees = np.array([body.joint("left_knee"), body.joint("right_knee")])
    centre, bottom, top = knees.mean(axis=0), knees[:, 1].mean(), body.joint("pelvis")[1] + 0.05
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    ring = np.stack([centre[0] + RADII[0] * np.cos(turn), centre[2] + RADII[1] * np.sin(turn)], axis=1)
    grid = np.stack(np.meshgrid(np.arange(-0.3, 0.3, 0.012), np.arange(-0.3, 0.3, 0.012)), axis=-1).reshape(-1, 2)
    inner = grid[((grid / np.array(RADII)) ** 2).sum(axis=1) < 0.9] + centre[[0, 2]]
    flat = np.concatenate([ring, inner])
    corners = Delaunay(flat).simplices
    at = flat[corners].mean(axis=1)
    corners = corners[(np.linalg.norm(at[:, None] - knees[:, [0, 2]], axis=2) > 0.07).all(axis=1)]
    rows = np.arange(bottom, top, 0.012)
    wall = [np.stack([ring[:, 0], np.full(AROUND, y), ring[:, 1]], axis=1) for y in rows[1:]]
    base = np.stack([flat[:, 0], np.full(len(flat), bottom), flat[:, 1]], axis=1)
    place = [np.arange(AROUND), *(len(flat) + AROUND * k + np.arange(AROUND) for k in range(len(wall)))]
    faces = [corners]
    for low, high in itertools.pairwise(place):
        a, b, c, d = low, np.roll(low, -1), high, np.roll(high, -1)
        faces += [np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]
    vertices, joined = np.concatenate([base, *wall]), np.concatenate(faces)
    sides = np.cross(
        vertices[corners[:, 1]] - vertices[corners[:, 0]], vertices[corners[:, 2]] - vertices[corners[:, 0]]
    )
    joined[: len(corners)] = np.where((sides[:, 1] > 0.0)[:, None], corners[:, ::-1], corners)
    used = np.unique(joined)
    index = np.full(len(vertices), -1)
    index[used] = np.arange(len(used))
    moved = vertices[used] + np.random.default_rng(0).normal(0.0, noise, (len(used), 3))
    return Scan(moved, index[joined])


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_a_capped_hem_is_one_opening(body, noise):
    """Broken where a skirt that a watertight scan has closed between the legs is taken for trousers."""
    scan = capped_skirt(body, noise)
    capped, _ = name_contours(scan.vertices, scan.faces, body, scanned=True)
    assert {contour.name for contour in capped} == {"leg.left", "leg.right", "waist"}
    part = cut_part(scan, np.ones(len(scan.vertices), bool), body)
    assert {contour.name for contour in part.contours} == {"hem", "waist"}
    hem = next(contour for contour in part.contours if contour.name == "hem")
    ellipse = np.pi * np.mean(RADII) * 2.0
    assert hem.length == pytest.approx(ellipse, rel=0.08)
    assert np.ptp(part.garment.vertices[hem.vertices, 1]) < 0.03


def test_trousers_keep_their_legs(body):
    """Broken where the crotch of trousers is cut out as if it were a cap."""
    trousers = load_draped_template("trousers")
    scan = Scan(trousers.nodes, trousers.faces)
    part = cut_part(scan, np.ones(len(scan.vertices), bool), body)
    assert {contour.name for contour in part.contours} == {"leg.left", "leg.right", "waist"}
    assert len(part.garment.vertices) == len(scan.vertices)


def test_the_seat_is_no_cap(body):
    """Broken where what faces down above the crotch is left out, as the seat of tight trousers does."""
    scan = Scan(body.vertices, body.faces)
    cap = find_hem_cap(scan, np.ones(len(scan.vertices), bool), body)
    assert scan.vertices[cap, 1].max() < body.joint("left_hip")[1] - 0.1
