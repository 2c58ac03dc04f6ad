"""Samples of a person and their features: even, the same twice, and the same in the mirror."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.geometry.point_normals import denoise_normals, orient_normals
from garmentq.core.people.features import FEATURE_LENGTH_SCALE, FEATURE_NAMES, describe_points
from garmentq.core.people.limbs import Limb, closest_in_triangles, place_on_body
from garmentq.core.people.neighbourhood import NEIGHBOURHOOD_RADII, neighbourhood_statistics
from garmentq.core.people.points import MAX_SAMPLE_BORDER_DISTANCE, MIN_SAMPLE_SPACING, PersonPoints, sample_person
from garmentq.core.scan.raw import RawScan
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class Fit:
    """Stand for a fit: the body is known."""

    body: Body


@pytest.fixture(scope="module")
def fit() -> Fit:
    """Return a person in A-pose whose body is known."""
    return Fit(builtin_body("builtin:female,pose=A"))


def raw_of(vertices: np.ndarray, faces: np.ndarray, colours: np.ndarray | None = None) -> RawScan:
    """Return a mesh as a raw scan; without faces a cloud that knows no normals."""
    count = np.arange(len(vertices))
    return RawScan(vertices, faces, None, False, colours, None, count, count)


def coat(body: Body, height: float = 0.015) -> np.ndarray:
    """Return the body's vertices, those of the upper arms raised [m] as by a sleeve."""
    arms = body.weights[:, [16, 17]].sum(axis=1) > 0.5
    return body.raised(np.where(arms, height, 0.0)).vertices


def test_samples_are_even_and_the_same_twice(fit):
    """Broken where samples crowd, leave gaps, or depend on anything but scan and seed."""
    body = fit.body
    raw = raw_of(body.vertices, body.faces, np.clip(body.vertices, 0, 1))
    points = sample_person(raw, fit)
    again = sample_person(raw, fit)
    assert np.array_equal(points.positions, again.positions)
    assert np.array_equal(points.nearest, again.nearest)
    assert 15_000 < len(points.positions) < 30_000
    tree = cKDTree(points.positions)
    assert tree.query(body.vertices)[0].max() < 2 * MIN_SAMPLE_SPACING
    step = tree.query(points.positions, k=2)[0][:, 1]
    assert np.quantile(step, 0.05) > 0.5 * MIN_SAMPLE_SPACING
    assert np.abs(np.linalg.norm(points.normals, axis=1) - 1).max() < 1e-6
    assert points.colours is not None
    carried = points.carry(points.positions)
    assert np.linalg.norm(carried - body.vertices, axis=1).max() < MIN_SAMPLE_SPACING
    # Some folds (armpits, between fingers) look like borders.
    assert np.median(points.border) > 0.8 * MAX_SAMPLE_BORDER_DISTANCE


def test_the_border_of_a_hole_is_found(fit):
    """Broken where the distance to the border forgets a hole, or is no distance."""
    body = fit.body
    centre = body.joint("spine2")
    front = np.linalg.norm((body.vertices - centre)[:, :2], axis=1) + 10 * (body.vertices[:, 2] < centre[2])
    keep = (front[body.faces] > 0.06).all(axis=1)
    used, faces = np.unique(body.faces[keep], return_inverse=True)
    points = sample_person(raw_of(body.vertices[used], faces.reshape(-1, 3)), fit)
    beside = points.positions[(points.border < 0.003) & (points.positions[:, 2] > centre[2])]
    assert (np.abs(np.linalg.norm((beside - centre)[:, :2], axis=1) - 0.07) < 0.02).sum() > 20


def test_normals_of_a_cloud_point_outward(fit):
    """Broken where normals of a cloud stay as the planes through their neighbours gave them."""
    body = fit.body
    raw = raw_of(coat(body), body.faces)
    dense = sample_person(raw, fit)
    cloud = raw_of(dense.positions, np.zeros((0, 3), dtype=np.int64))
    points = sample_person(cloud, fit)
    true = dense.normals[cKDTree(dense.positions).query(points.positions)[1]]
    assert (np.einsum("na,na->n", points.normals, true) > 0).mean() > 0.99
    flipped = dense.normals * np.random.default_rng(0).choice([-1.0, 1.0], len(dense.normals))[:, None]
    turned = orient_normals(dense.positions, flipped, body.vertices, vertex_normals(body.vertices, body.faces))
    assert (np.einsum("na,na->n", turned, dense.normals) > 0).mean() > 0.99


def test_normals_that_are_noise_are_averaged_and_others_are_kept(fit):
    """Broken where a noisy scan's normals point anywhere, or a clean one's edges are rounded."""
    body = fit.body
    points = sample_person(raw_of(body.vertices, body.faces), fit)
    assert denoise_normals(points.positions, points.normals) is points.normals
    noisy = points.normals + np.random.default_rng(0).normal(scale=0.5, size=points.normals.shape)
    noisy /= np.linalg.norm(noisy, axis=1, keepdims=True)
    calm = denoise_normals(points.positions, noisy)
    off = [np.median(np.arccos(np.einsum("na,na->n", found, points.normals))) for found in (noisy, calm)]
    assert off[1] < 0.6 * off[0]


def test_offsets_and_steps_of_a_sleeve(fit):
    """Broken where the offset is no height over the body, or a sleeve's end no step down the arm."""
    body = fit.body
    points = sample_person(raw_of(coat(body), body.faces), fit)
    features = describe_points(points, fit)
    assert features.names == FEATURE_NAMES
    assert features.values.shape == (len(points.positions), len(FEATURE_NAMES))
    assert features.values.dtype == np.float32
    assert np.isfinite(features.values).all()
    place = features.place
    arm = np.isin(place.limb, (Limb.LEFT_ARM, Limb.RIGHT_ARM))
    upper = arm & (place.weights[:, [16, 17]].sum(axis=1) > 0.95)
    bare = (place.parts[:, FEATURE_NAMES.index("part_forearm") - FEATURE_NAMES.index("part_pelvis")] > 0.9) & arm
    assert np.median(features.column("offset")[upper]) * FEATURE_LENGTH_SCALE == pytest.approx(0.015, abs=0.001)
    assert abs(np.median(features.column("offset")[bare])) * FEATURE_LENGTH_SCALE < 0.001
    elbow = body.rest_joints[18, 0] - body.rest_joints[16, 0]
    at_end = arm & (np.abs(place.station - elbow) < 0.02)
    assert features.column("offset_step_40")[at_end].min() * FEATURE_LENGTH_SCALE < -0.008
    assert features.column("slice_step")[at_end].min() * FEATURE_LENGTH_SCALE < -0.008


def test_the_mirror_changes_no_feature(fit):
    """Broken where a feature tells left from right."""
    body = fit.body
    flip = np.array([-1.0, 1.0, 1.0])
    points = sample_person(raw_of(coat(body), body.faces), fit)
    order = np.random.default_rng(0).permutation(len(points.positions))
    other = PersonPoints(
        points.positions[order] * flip,
        points.normals[order] * flip,
        None,
        points.spacing,
        points.border[order],
        points.nearest,
        points.weights,
    )
    pairs = [1, 2, 4, 5, 7, 8, 10, 11, 13, 14, 16, 17, 18, 19, 20, 21, 22, 23]
    swap = np.arange(24)
    swap[pairs] = np.array(pairs).reshape(-1, 2)[:, ::-1].ravel()
    turn = np.diag([-1.0, 1.0, 1.0, 1.0])
    mirrored = replace(
        body,
        vertices=body.vertices * flip,
        faces=body.faces[:, ::-1],
        joints=(body.joints * flip)[swap],
        weights=body.weights[:, swap],
        transforms=(turn @ body.transforms @ turn)[swap],
        rest_vertices=body.rest_vertices * flip,
        rest_faces=body.rest_faces[:, ::-1],
        rest_joints=(body.rest_joints * flip)[swap],
        rest_weights=body.rest_weights[:, swap],
    )
    ours, theirs = describe_points(points, fit), describe_points(other, Fit(mirrored))
    wrong = np.abs(ours.values[order] - theirs.values) > 1e-3
    # In the middle plane a sample belongs to neither side.
    middle = np.abs(ours.place.rest[order, 0]) < 1e-6
    assert wrong[~middle].mean() < 1e-3


def test_neighbourhoods_of_a_ball_and_of_a_step():
    """Broken where curvature is not 1 / R, or a step is not the difference of its two sides."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(60_000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    radius = 0.3
    up = np.tile([0.0, 1.0, 0.0], (len(normals), 1))
    offset = np.where(normals[:, 1] > 0, 0.02, 0.0)
    found = neighbourhood_statistics(radius * normals, normals, offset, up)
    for reach, values in zip(NEIGHBOURHOOD_RADII, found, strict=True):
        assert np.median(values[:, 3]) == pytest.approx(1 / radius, rel=0.02)
        edge = np.abs(radius * normals[:, 1]) < 0.1 * reach
        assert np.median(values[edge, 2]) == pytest.approx(0.02, rel=0.1)
        away = np.abs(radius * normals[:, 1]) > 1.1 * reach
        assert np.abs(values[away, :2] - np.stack([offset, 0 * offset], axis=1)[away]).max() < 1e-8


def test_nearest_points_in_triangles():
    """Broken where a point beyond an edge or a corner is given another foot than the nearest."""
    rng = np.random.default_rng(1)
    corners, points = rng.normal(size=(50, 3, 3)), rng.normal(size=(50, 3)) * 2
    share = closest_in_triangles(points, corners)
    found = np.linalg.norm(np.einsum("nk,nka->na", share, corners) - points, axis=1)
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 60)] * 2), axis=-1).reshape(-1, 2)
    grid = grid[grid.sum(axis=1) <= 1]
    every = np.concatenate([1 - grid.sum(axis=1, keepdims=True), grid], axis=1)
    best = np.linalg.norm(np.einsum("gk,nka->nga", every, corners) - points[:, None], axis=2).min(axis=1)
    assert (found <= best + 1e-9).all()
    assert np.abs(found - best).max() < 0.05
    assert share.min() >= 0


def test_vertices_of_the_body_lie_on_it(fit):
    """Broken where places on the body are those of another limb or pose."""
    body = fit.body
    normals = vertex_normals(body.vertices, body.faces)
    zero = np.zeros((0, 3))
    points = PersonPoints(body.vertices, normals, None, MIN_SAMPLE_SPACING, np.zeros(len(normals)), zero, zero)
    place = place_on_body(points, body)
    assert np.quantile(place.distance, 0.95) < 1e-3
    assert np.quantile(np.linalg.norm(place.rest - body.rest_vertices, axis=1), 0.95) < 2e-3
    assert np.abs(place.parts.sum(axis=1) - 1).max() < 1e-8
