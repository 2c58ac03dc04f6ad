"""Transfer the waist of a garment to another body."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...body.registration import register_body
from ...body.skinning import skin, unskin, weights_at
from ...geometry.surface import TriangleSurface


def transfer_curve(curve: np.ndarray, old: Body, new: Body) -> np.ndarray:
    """Move points on a wearer to the same place of another body, at the same distance from the skin, [m], [n, 3].

    Both bodies' fitted models share a topology, so a place of the skin is a face and weights of its corners. Points are
    mapped through both T-poses. On the same body they do not move.

    Args:
        curve: Points on or near the old body's skin, in its pose [m], shape [n, 3].
        old: The wearer.
        new: The other body.
    """
    if is_same_body(old, new):
        return curve
    faces, was, now = match_models(old, new)
    points = unskin(curve, weights_at(old, curve, rest=False), old.transforms)
    before, after = TriangleSurface(was, faces), TriangleSurface(now, faces)
    found = before.closest(points)
    normals = [found.interpolate(surface.vertex_normals, faces) for surface in (before, after)]
    height = ((points - found.foot) * normals[0]).sum(axis=1, keepdims=True)
    moved = found.interpolate(now, faces) + height * normals[1]
    return skin(moved, weights_at(new, moved, rest=True), new.transforms)


def match_models(old: Body, new: Body) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return faces [f, 3] that two bodies share, and the vertices of both in their T-poses [m], [n, 3] each. The
    built-in body is fitted to both where their models differ (one is in SMPL's format)."""
    if np.array_equal(old.rest_faces, new.rest_faces):
        return old.rest_faces, old.rest_vertices, new.rest_vertices
    models = []
    for body in (old, new):
        fitted = register_body(body.rest_vertices, body.rest_faces)
        models.append(skin(fitted.rest_vertices, fitted.rest_weights, fitted.transforms))
    return fitted.rest_faces, models[0], models[1]


def is_same_body(old: Body, new: Body) -> bool:
    """Check whether two bodies are the same, in the same pose."""
    return old is new or (np.array_equal(old.vertices, new.vertices) and np.array_equal(old.transforms, new.transforms))
