"""Edges that a fused scan has rounded, on tubes and cones whose true edge is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.geometry.geometry import face_normals
from garmentq.core.scan.contours.rounded_rims import (
    MAX_RIM_FIT_DISTANCE,
    ROUNDED_RIM_WIDTH,
    STRAIGHTENED_RIM_NOTE,
    straighten_rims,
    straighten_scan,
)
from garmentq.core.scan.scan import Scan

RADIUS, LENGTH, EDGE = 0.05, 0.10, 0.004
DEEP = 0.005
"""How far the surface lies inside the cloth at its edge [m]."""


def roll_sleeve(edge: float, flare: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a tube of cloth around the x axis from 0 to `LENGTH`, its faces, and the way of each vertex to x = 0."""
    around = round(2.0 * np.pi * RADIUS / edge)
    x, turn = np.meshgrid(np.arange(0.0, LENGTH + edge / 2, edge), np.arange(around), indexing="ij")
    angle = 2.0 * np.pi * turn.ravel() / around
    radius = RADIUS + flare * x.ravel()
    points = np.stack([x.ravel(), radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    row, column = np.meshgrid(np.arange(x.shape[0] - 1), np.arange(around), indexing="ij")
    a, b = row * around + column, row * around + (column + 1) % around
    quads = np.stack([a, b, a + around, b, b + around, a + around], axis=-1)
    return points, quads.reshape(-1, 3), x.ravel()


def round_off(points: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Bend the last `ROUNDED_RIM_WIDTH` before the edge inward, by `DEEP` at the edge."""
    bent = points.copy()
    depth = DEEP * np.clip(1.0 - way / ROUNDED_RIM_WIDTH, 0.0, 1.0) ** 2
    bent[:, 1:] *= (1.0 - depth / np.linalg.norm(points[:, 1:], axis=1))[:, None]
    return bent


def far_off(found: np.ndarray, chosen: np.ndarray, flare: float = 0.0) -> np.ndarray:
    """Return by how much some vertices are farther from the axis than the cloth there [m]."""
    return np.linalg.norm(found[chosen, 1:], axis=1) - (RADIUS + flare * found[chosen, 0])


@pytest.mark.parametrize("flare", [0.0, 0.3, -0.3])
def test_a_cut_edge_goes_on_as_the_cloth_does(flare: float) -> None:
    """Fails if a cuff stayed as narrow as the scan has it, if a flared one lost its flare, or if cloth slid along."""
    true, faces, way = roll_sleeve(EDGE, flare)
    unseen = way > LENGTH / 2
    found = straighten_rims(round_off(true, way), faces, unseen)
    assert np.abs(far_off(found, way < 1e-9, flare)).max() < 0.1 * DEEP
    assert np.abs(found[:, 0] - true[:, 0]).max() < 2e-3


def test_a_cut_below_an_overhang_is_laid_even() -> None:
    """Fails if vertices that lie below the cloth's end are lifted one by one: their faces fold over those beside them.

    How a neckline turns is told by the angles of the faces at it, which a folded one has the wrong way round.
    """
    true, faces, way = roll_sleeve(0.001)
    turn, bend = np.arctan2(true[:, 2], true[:, 1]), np.pi * np.clip((0.010 - way) / 0.008, 0.0, 1.0)
    curled = true.copy()
    curled[:, 0] = np.maximum(way, 0.010) - 0.5 * DEEP * np.sin(bend)
    curled[:, 1:] *= (1.0 - 0.5 * DEEP / RADIUS * (1.0 - np.cos(bend)))[:, None]
    kept = faces[(way > 0.004 + 0.001 * np.sin(12.0 * turn))[faces].all(axis=1)]
    found = straighten_rims(curled, kept, way > LENGTH / 2)
    normals, middle = face_normals(found, kept)[0], found[kept].mean(axis=1)
    outward = (normals[:, 1:] * middle[:, 1:]).sum(axis=1) / np.linalg.norm(middle[:, 1:], axis=1)
    assert (outward > 0.5).all()
    rim = HalfEdges.of(kept, len(true)).border_vertices & (way < LENGTH / 2)
    assert np.abs(far_off(found, rim)).max() < 0.2 * DEEP


def test_an_edge_of_the_scan_itself_and_all_that_is_farther_stays() -> None:
    """Fails if an edge at which the scan ends, which nothing rounds, or cloth beyond the edge's reach, were moved."""
    true, faces, way = roll_sleeve(EDGE)
    bent = round_off(true, way) + round_off(true, LENGTH - way) - true
    found = straighten_rims(bent, faces, way > LENGTH / 2)
    np.testing.assert_array_equal(found[way > ROUNDED_RIM_WIDTH + 1e-9], bent[way > ROUNDED_RIM_WIDTH + 1e-9])
    assert (HalfEdges.of(faces, len(true)).border_vertices & (way > LENGTH / 2)).any()


def test_what_covers_a_garment_draws_its_edge_outward() -> None:
    """Fails if trousers bulged where they go on below a top, or if skin beyond a neckline were pulled to the cloth."""
    true, faces, way = roll_sleeve(EDGE)
    bulged = 2.0 * true - round_off(true, way)
    unseen, hidden, edge = way > LENGTH / 2, way < 1e-9, way < 1e-9
    assert np.abs(far_off(straighten_rims(bulged, faces, unseen, hidden), edge)).max() < 0.1 * DEEP
    np.testing.assert_array_equal(straighten_rims(bulged, faces, unseen)[edge], bulged[edge])


def test_noise_is_not_drawn_out_at_the_edge() -> None:
    """Fails if 2 mm of noise tilted the cloth beside an edge so much that the edge were worse off than it was."""
    true, faces, way = roll_sleeve(EDGE)
    noisy = round_off(true, way) + np.random.default_rng(3).normal(0.0, 2e-3, true.shape)
    found = straighten_rims(noisy, faces, way > LENGTH / 2)
    edge = way < 1e-9
    assert abs(far_off(found, edge).mean()) < 0.2 * DEEP
    assert far_off(found, edge).std() < 2.5e-3


def test_only_what_was_cut_out_of_a_larger_surface_is_straightened() -> None:
    """Fails if a garment that was given alone were changed, or if nobody were told of what was."""
    true, faces, way = roll_sleeve(EDGE)
    alone = Scan(round_off(true, way), faces)
    assert straighten_scan(alone) is alone
    cut = straighten_scan(replace(alone, unseen=way > LENGTH / 2))
    assert np.abs(far_off(cut.vertices, way < 1e-9)).max() < 0.1 * DEEP
    assert cut.repairs == (STRAIGHTENED_RIM_NOTE,)


def test_a_fine_surface_leads_as_a_coarse_one_does() -> None:
    """Fails if of a dense scan only the nearest few millimetres were asked, whose noise would tilt the edge."""
    true, faces, way = roll_sleeve(0.3 * EDGE)
    noisy = round_off(true, way) + np.random.default_rng(3).normal(0.0, 2e-4, true.shape)
    found = straighten_rims(noisy, faces, way > LENGTH / 2)
    assert np.abs(far_off(found, way < 1e-9)).max() < 0.4 * DEEP


def test_a_coarse_surface_stays_as_it_is() -> None:
    """Fails if so few vertices that they lie all around a cuff were asked for its edge, or if that were told."""
    true, faces, way = roll_sleeve(0.7 * MAX_RIM_FIT_DISTANCE)
    bent = round_off(true, way)
    np.testing.assert_array_equal(straighten_rims(bent, faces, way > LENGTH / 2), bent)
    coarse = Scan(bent, faces, unseen=way > LENGTH / 2)
    assert straighten_scan(coarse) is coarse
