"""What is left of a floor about the feet is neither shoe nor skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.people.features import describe_points
from garmentq.core.people.part import PARTS, Part
from garmentq.core.people.points import sample_person
from garmentq.core.people.prior import stray_probability
from garmentq.core.people.rules import predict_by_rules
from garmentq.core.scan.raw import RawScan


@dataclass(frozen=True)
class Fit:
    """Stand for a fit: the body is known."""

    body: Body


def floor_about(body: Body, step: float = 0.01, reach: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """Return a level square below the feet, vertices [m] and faces that face up."""
    low = body.vertices[:, 1].min()
    feet = body.vertices[body.vertices[:, 1] < low + 0.05].mean(axis=0)
    count = int(2 * reach / step)
    x, z = (axis.ravel() for axis in np.meshgrid(*(np.linspace(-reach, reach, count),) * 2, indexing="ij"))
    vertices = np.column_stack([feet[0] + x, np.full(len(x), low), feet[2] + z])
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    faces = [[corner, corner + 1, corner + count + 1], [corner, corner + count + 1, corner + count]]
    return vertices, np.concatenate([np.column_stack(three) for three in faces])


def test_a_floor_is_no_shoe_and_bare_feet_are_no_floor():
    """Broken where what is left of a floor is called shoes, or a foot or sole is called floor."""
    fit = Fit(builtin_body("builtin:female,pose=A"))
    body = fit.body
    floor, faces = floor_about(body)
    vertices = np.concatenate([body.vertices, floor])
    count = np.arange(len(vertices))
    faces = np.concatenate([body.faces, faces + len(body.vertices)])
    points = sample_person(RawScan(vertices, faces, None, False, None, None, count, count), fit)
    features = describe_points(points, fit)
    found = predict_by_rules(points, features, fit).argmax(axis=1)
    below = np.abs(points.positions[:, 1] - floor[0, 1]) < 0.003
    ground = below & (points.normals[:, 1] > 0.9) & (features.column("distance") > 2.0)
    assert ground.sum() > 1000
    assert (found[ground] == PARTS.index(Part.OTHER)).mean() > 0.95
    alone = np.arange(len(body.vertices))
    points = sample_person(RawScan(body.vertices, body.faces, None, False, None, None, alone, alone), fit)
    assert stray_probability(points, describe_points(points, fit)).max() < 0.01


def test_a_skirt_far_from_the_shanks_is_cloth():
    """Broken where what lies far from the legs counts as remains of a floor that the scan does not have."""
    fit = Fit(builtin_body("builtin:female,pose=A"))
    body = fit.body
    around, rows = 120, 30
    turns = np.arange(around) * 2 * np.pi / around
    angle, height = (axis.ravel() for axis in np.meshgrid(turns, np.linspace(0.08, 0.5, rows)))
    low = body.vertices[:, 1].min()
    tube = np.column_stack([0.35 * np.sin(angle), low + height, 0.35 * np.cos(angle)])
    start = (np.arange(rows - 1)[:, None] * around + np.arange(around)).ravel()
    after = (np.arange(rows - 1)[:, None] * around + (np.arange(around) + 1) % around).ravel()
    sides = np.concatenate([
        np.column_stack([start, after, after + around]), np.column_stack([start, after + around, start + around])
    ])  # fmt: skip
    vertices = np.concatenate([body.vertices, tube])
    count = np.arange(len(vertices))
    faces = np.concatenate([body.faces, sides + len(body.vertices)])
    points = sample_person(RawScan(vertices, faces, None, False, None, None, count, count), fit)
    features = describe_points(points, fit)
    assert (features.column("distance") > 3.0).sum() > 500
    assert not stray_probability(points, features).any()
