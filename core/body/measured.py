"""The most probable shape of the built-in body with given measures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..run.errors import BadInput
from .body import Body
from .girths import TapeMeasure
from .template import Template

BODY_DENSITY = 985.0
"""Mean density of a living body with air in its lungs [kg/m3]: converts the mesh's volume to weight. Assumed: bodies
are between about 0.94 (lungs full) and 1.06 (lungs empty, lean) times water's."""

MAX_GIRTH_Z_SCORE = 3.0
"""Largest deviation of a girth from the most probable one given the measures before it [standard deviations]. Of bodies
like those from which the shape directions were made, one in 370 deviates more; there the model extrapolates."""

MAX_SHAPE_ITERATIONS = 40
"""Largest number of Newton steps: without girths three to five are taken, with five at the ends of their ranges 20."""

NEWTON_STEP_FRACTIONS = (1.0, 0.5, 0.25, 0.1)
"""Fractions of a Newton step that are tried until one reduces the mismatch; the last is taken in any case. A full step
may fail, because the heights of the narrowest and the widest place are discontinuous."""

GIRTH_SOLVE_TOLERANCE = 1e-4
"""Mismatch of a girth at which the search ends [m]: a thirtieth of `MAX_GIRTH_MISMATCH`."""

MAX_GIRTH_MISMATCH = 3e-3
"""Largest mismatch of a girth that is accepted [m]: the error of a tape measure."""


class MeasureRange(BadInput):
    """A measure lies outside what the built-in body can have with the other measures; the message has the range."""

    code = "body.measure_range"


@dataclass(frozen=True)
class TargetMeasures:
    """Describe the measures of a wanted shape.

    Attributes:
        gender: `female` or `male`.
        height: From the soles to the crown [m].
        weight: [kg], or None: the most probable.
        girths: Some of `GIRTHS` [m].
    """

    gender: str
    height: float
    weight: float | None = None
    girths: Mapping[str, float] | None = None


def most_probable_shape(template: Template, measures: TargetMeasures) -> np.ndarray:
    """Compute the most probable shape coefficients [k] of a gender with a height, and optionally a weight and girths.

    With z ~ N(mean, C) and the constraints c(z) = t, minimise (z - mean)' C^-1 (z - mean) subject to c(z) = t: each
    Newton step on the linearised constraints is z = mean + C A' (A C A')^-1 (t - c(z) + A (z - mean)), with A the
    derivative of c. The volume is cubic and the height piecewise linear in z, a girth nearly linear. Girths are added
    one by one, so that each is checked against its distribution given those before it.

    Raises:
        MeasureRange: where a girth is further than `MAX_GIRTH_Z_SCORE` standard deviations from the most probable one.
    """
    girths = dict(measures.girths or {})
    shape = _solve(template, measures, (), template.means[measures.gender])
    for count, name in enumerate(girths, start=1):
        _check_range(template, measures, tuple(girths)[: count - 1], name, shape)
        shape = _solve(template, measures, tuple(girths)[:count], shape)
    return shape


def nearest_shape(template: Template, start: np.ndarray, measures: TargetMeasures) -> np.ndarray:
    """Compute the shape coefficients [k] with a height and girths that are nearest to given ones.

    Minimise (z - start)' C^-1 (z - start) subject to the measures, C the gender's covariance: what is not measured
    changes with the measures as it does in the population.

    Raises:
        MeasureRange: where the measures cannot be met.
    """
    return _solve(template, measures, tuple(measures.girths or {}), start, start)


def t_pose_body(template: Template, shape: np.ndarray) -> Body:
    """Return the built-in body of a shape in its T-pose, at the model's origin."""
    vertices, joints = template.shaped(shape)
    eyes = np.tile(np.eye(4), (len(joints), 1, 1))
    faces, weights = template.faces, template.weights
    return Body(vertices, faces, joints, weights, eyes, vertices, faces, joints, weights, np.eye(3))


def volume_of(vertices: np.ndarray, faces: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the enclosed volume [m3] and its derivative by the vertices [n, 3]."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    slope = np.zeros_like(vertices)
    for k, opposite in enumerate((np.cross(b, c), np.cross(c, a), np.cross(a, b))):
        np.add.at(slope, faces[:, k], opposite / 6)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6), slope


def _solve(
    template: Template,
    measures: TargetMeasures,
    names: tuple[str, ...],
    start: np.ndarray,
    other: np.ndarray | None = None,
) -> np.ndarray:
    """Search the shape with height, weight and girths that is nearest to the gender's mean or to the shape `other`."""
    mean, covariance = template.means[measures.gender], template.covariances[measures.gender]
    mean = mean if other is None else other
    shape, scale = start.copy(), _scale(measures, names)
    values, a = _constraints(template, measures, names, shape)
    for step in range(MAX_SHAPE_ITERATIONS):
        gap = _targets(measures, names) - values
        if step > 0 and np.abs(gap).max() < (GIRTH_SOLVE_TOLERANCE if names else 1e-9):
            break
        moved = mean + covariance @ a.T @ np.linalg.solve(a @ covariance @ a.T, gap + a @ (shape - mean))
        # The heights of the narrowest and the widest place are discontinuous: a step that does not help is shortened.
        for share in NEWTON_STEP_FRACTIONS:
            tried = shape + share * (moved - shape)
            values, a = _constraints(template, measures, names, tried)
            if step == 0 or np.abs(scale * (_targets(measures, names) - values)).max() < np.abs(scale * gap).max():
                break
        shape = tried
    if names:
        values, _ = _constraints(template, measures, names, shape)
        missed = np.abs(_targets(measures, names) - values)[-len(names) :]
        if missed.max() > MAX_GIRTH_MISMATCH:
            worst = names[int(missed.argmax())]
            raise MeasureRange(
                f"{worst}={(measures.girths or {})[worst]:g} m cannot be met together with the other measures (by "
                f"{1e3 * missed.max():.0f} mm); leave out the measures that matter least."
            )
    return shape


def _scale(measures: TargetMeasures, names: tuple[str, ...]) -> np.ndarray:
    """Return the weights by which mismatches are compared: a litre of volume counts as a centimetre of length."""
    return np.array([1.0] + [10.0] * (measures.weight is not None) + [1.0] * len(names))


def _targets(measures: TargetMeasures, names: tuple[str, ...]) -> np.ndarray:
    weight = [] if measures.weight is None else [measures.weight / BODY_DENSITY]
    return np.array([measures.height, *weight, *((measures.girths or {})[name] for name in names)])


def _constraints(
    template: Template, measures: TargetMeasures, names: tuple[str, ...], shape: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return height, volume and girths of a shape, and their derivatives by its coefficients, shape [n, k]."""
    body = t_pose_body(template, shape)
    vertices = body.vertices
    top, bottom = vertices[:, 1].argmax(), vertices[:, 1].argmin()
    values = [float(vertices[top, 1] - vertices[bottom, 1])]
    slopes = [template.directions[:, top, 1] - template.directions[:, bottom, 1]]
    if measures.weight is not None:
        volume, slope = volume_of(vertices, template.faces)
        values.append(volume)
        slopes.append(np.tensordot(template.directions, slope, axes=2))
    tape = TapeMeasure(body)
    for name in names:
        girth = tape.measure(name)
        values.append(girth.value)
        slopes.append(np.tensordot(template.directions, girth.slope, axes=2))
    return np.array(values), np.array(slopes)


def _check_range(
    template: Template, measures: TargetMeasures, known: tuple[str, ...], name: str, shape: np.ndarray
) -> None:
    """Check a girth against its spread around the most probable one given the measures before it. With C given A: C - C
    A' (A C A')^-1 A C, the variance of a girth with derivative a is a C_A a'."""
    covariance = template.covariances[measures.gender]
    values, a = _constraints(template, measures, (*known, name), shape)
    before, last = a[:-1], a[-1]
    left = last @ covariance - last @ covariance @ before.T @ np.linalg.solve(
        before @ covariance @ before.T, before @ covariance
    )
    reach = MAX_GIRTH_Z_SCORE * float(np.sqrt(max(left @ last, 0.0)))
    low, high = values[-1] - reach, values[-1] + reach
    girth = (measures.girths or {})[name]
    if not low <= girth <= high:
        raise MeasureRange(
            f"{name}={girth:g} is outside {low:.2f} to {high:.2f} m, which is what a {measures.gender} body has with "
            f"the measures before it (girths are in metres)."
        )
