"""Holes that broke through a contour are bridged; what was designed stays."""

from itertools import pairwise

import numpy as np
import pytest
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.contours.rim_gaps import bridge_bays, bridge_bites


def rim(count=160, radius=0.2):
    """Return a hem seen from above, counter-clockwise: the garment lies above it."""
    angle = -2 * np.pi * np.arange(count) / count
    return np.stack([radius * np.cos(angle), 0 * angle, radius * np.sin(angle)], axis=1)


def torn(points, start=40, mouth=4, depth=0.12):
    """Return a hem with a slit-shaped tear upward whose mouth spans a few points."""
    up = np.linspace(0, depth, 13)[1:, None] * [0.0, 1.0, 0.0]
    first, last = points[start], points[start + mouth]
    tear = np.concatenate([first + up, last + up[::-1]])
    return np.concatenate([points[: start + 1], tear, points[start + mouth :]])


def outward(points):
    """Return the normals of cloth around the y axis, as `bridge_bites` asks for them."""
    flat = points * [1.0, 0.0, 1.0]
    return lambda: flat / np.linalg.norm(flat, axis=1, keepdims=True)


@pytest.mark.parametrize("shift", [0, 45, 100])
def test_tear_is_bridged_wherever_the_loop_starts(shift):
    """A tear must leave the hem at its mouth, also when the loop happens to start inside it."""
    points = np.roll(torn(rim()), -shift, axis=0)
    kept, bites = bridge_bites(points, outward(points))
    assert len(bites) == 1
    assert np.abs(points[kept, 1]).max() < 0.011 and points[bites[0], 1].max() == pytest.approx(0.12)
    assert sorted({*kept.tolist(), *bites[0].tolist()}) == list(range(len(points)))
    length = np.linalg.norm(points[kept] - np.roll(points[kept], 1, axis=0), axis=1).sum()
    assert length == pytest.approx(2 * np.pi * 0.2, rel=0.02)


def test_folds_and_necklines_stay():
    """A fold of a hem, a V-neck and a scallop are design, and must not be cut off."""
    angle = 2 * np.pi * np.arange(400) / 400
    folded = rim(400) * (1 + 0.35 * np.cos(12 * angle))[:, None]
    neck = rim(160, 0.09)
    neck[:, 1] = np.maximum(0.0, 0.12 - 1.5 * np.abs(neck[:, 0])) * (neck[:, 2] > 0)
    for points in (folded, neck):
        kept, bites = bridge_bites(points, outward(points))
        assert bites == () and np.array_equal(kept, np.arange(len(points)))


def test_a_fold_that_rises_goes_around_air():
    """A flared hem whose fold lies higher on one side must keep its length: no surface is missing within the fold."""
    points = rim(160, 0.3)
    side, out = points[44] - points[40], points[40] / np.linalg.norm(points[40])
    side /= np.linalg.norm(side)
    knots = [(0.0, 0.0, 0.0), (0.016, 0.06, 0.02), (0.096, 0.1, 0.05), (0.072, 0.02, 0.09), (0.008, 0.0, 0.09)]
    fold = np.array([points[40] + along * side + away * out + [0.0, up, 0.0] for along, away, up in knots])
    fold = [np.linspace(start, end, 6)[:-1] for start, end in pairwise(fold)]
    points[45:85, 1] += np.linspace(0.09, 0.0, 40)
    points = np.concatenate([points[:40], *fold, points[45:]])
    assert bridge_bites(points, outward(points))[1] == ()
    assert bridge_bites(points, lambda: -outward(points)())[1] != ()


@pytest.mark.parametrize(("half_width", "tears"), [(0.06, False), (0.012, True)])
def test_a_pointed_neck_is_no_bite(half_width, tears):
    """Broken where a V whose edges curl loses its point, or a tear in a neck is taken for one."""
    neck = rim(800, 0.09)
    share = np.clip(1.0 - np.abs(neck[:, 0]) / half_width, 0.0, 1.0) * (neck[:, 2] > 0)
    neck[:, 1] = 0.15 * share**1.2
    assert bool(bridge_bites(neck, outward(neck), pointed=True)[1]) is tears
    assert bridge_bites(neck, outward(neck))[1] != ()


@pytest.mark.parametrize(("tilt", "count"), [(3.0, 0), (30.0, 1)])
def test_an_area_vector_across_the_normal_says_nothing(tilt, count):
    """Broken where chance decides whether a fold is a bite, or where a bite has to be exactly in the surface."""
    points, angle = torn(rim(), mouth=6), np.radians(tilt)
    normals = np.sin(angle) * outward(points)() + np.cos(angle) * np.array([0.0, 1.0, 0.0])
    assert len(bridge_bites(points, lambda: normals)[1]) == count


def test_long_contours_are_searched_coarsely():
    """A contour of thousands of points must not need a table of all pairs, and still lose its tear."""
    points = torn(rim(6000), start=1000, mouth=150)
    _, bites = bridge_bites(points, outward(points))
    assert len(bites) == 1


def test_torn_hem_keeps_its_length(wearers, hung):
    """A hole that eats into a hem must become a hole beside a hem of the old length."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.61, 0.35, around=96, rows=40)
    whole, _ = name_contours(vertices, faces, body)
    centres = vertices[faces].mean(axis=1)
    height = centres[:, 1] - vertices[:, 1].min()
    gone = (centres[:, 2] > 0) & (np.abs(centres[:, 0]) < 0.02) & (height < 0.2)
    gone |= (
        np.linalg.norm(
            centres - centres[np.argmin(np.abs(centres[:, 0]) - centres[:, 2] + np.abs(height - 0.2))], axis=1
        )
        < 0.07
    )
    contours, holes = name_contours(vertices, faces[~gone], body, scanned=True)
    assert [contour.name for contour in contours] == ["hem", "waist"] and len(holes) == 1
    hem, before = contours[0], whole[0]
    assert hem.length == pytest.approx(before.length, rel=0.02)
    # Of a mesh of ours it is design, as a deep neckline is.
    drawn, none = name_contours(vertices, faces[~gone], body)
    assert none == () and drawn[0].length > 1.2 * before.length


def test_a_hem_that_stands_off_the_skin_is_no_bay():
    """Cloth below which little of the wearer is seen must keep its hem: the stretch goes around the tube."""
    points = rim(510)
    normals = outward(points)() - [0.0, 0.3, 0.0]  # flared: their sum points down, against the area vector
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    unseen = np.ones(510, bool)
    unseen[100:120] = False
    kept, bays = bridge_bays(points, normals, unseen)
    assert bays == () and len(kept) == 510


def test_a_bay_without_skin_beyond_is_bridged():
    """A round bite in a hem beyond which nothing was seen must leave the hem at its mouth."""
    points = rim()
    turn, first, last = np.linspace(0, np.pi, 25)[1:-1], points[40], points[56]
    bite = 0.5 * (first + last) - 0.5 * np.cos(turn)[:, None] * (last - first)
    bite += np.sin(turn)[:, None] * [0.0, 0.06, 0.0]
    points = np.concatenate([points[:41], bite, points[56:]])
    unseen = np.zeros(len(points), bool)
    unseen[41:64] = True
    kept, bays = bridge_bays(points, outward(points)(), unseen)
    assert len(bays) == 1 and np.abs(points[kept, 1]).max() < 0.011


def test_a_bay_of_a_noisy_scan_is_bridged(wearers, hung):
    """Noise as large as half an edge must not hide a bay: the means of scattered normals are short, not their way."""
    body = wearers["T"]
    vertices, faces = hung(body, 0.61, 0.35, around=480, rows=200)
    whole, _ = name_contours(vertices, faces, body)
    hem = vertices[whole[0].vertices]
    place = hem[np.argmax(hem[:, 2])]
    gone = (np.linalg.norm(vertices - place, axis=1) < 0.04)[faces].any(axis=1)
    noisy = vertices + np.random.default_rng(3).normal(0.0, 0.002, vertices.shape)
    unseen = np.zeros(len(vertices), bool)
    unseen[faces[gone]] = True
    contours, holes = name_contours(noisy, faces[~gone], body, unseen)
    assert [contour.name for contour in contours] == ["hem", "waist"] and len(holes) == 1
    assert contours[0].length == pytest.approx(whole[0].length, rel=0.02)
