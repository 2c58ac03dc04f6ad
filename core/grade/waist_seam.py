"""Find the line across front and back at which a bodice and a skirt were sewn together: there the cloth is curved."""

from __future__ import annotations

from collections.abc import Container

import numpy as np

from ..body import Body, rest_body
from ..drape import measure_wearer
from ..mesh import HalfEdges, corner_angles, unit
from ..pattern.parts import Cut, Skirt
from ..segment import Target

BETWEEN = 0.16
"""How far to both sides of the middle plane curvature is counted, by the waist's girth: 13 cm of 82. Half the width of
a waist is 0.19 of its girth and more, and at the sides a dress in one piece is curved by its side seams."""

BAND, BANDS = 0.04, 8
"""Height [m] of the bands by which curvature is summed, and their number, half of them below the waist. A seam across
lies within two of them; together they reach from below the bust to the hips."""

CURVED = 1.0
"""Curvature [rad] from which a line is believed, of front and back together. Four dresses with darts at a waist seam,
draped by another simulator, have 2.3 to 5.5; drawn and published garments without one, at up to 1 mm of noise, 0.6 at
most."""

SHARE = 0.5
"""Of the absolute curvature of all bands that the line's two have at least: cloth that is strained or crumpled is
curved everywhere."""

SHEATHS = (Skirt.STRAIGHT, Skirt.PENCIL, Skirt.A_LINE)
"""Skirts whose upper edge, without darts, is nearly straight, as a bodice's lower one is: sewn together these leave no
curvature. Circles and gathers do."""


def sew_waist(cut: Cut, fixed: Container[str]) -> Cut:
    """Return a cut as it is where its waist is curved: sewn at the waist, with darts where a straight edge would be.

    Args:
        cut: The cut; any that has no place for a waist seam stays.
        fixed: Parts that stay.
    """
    if "waist" in fixed or not cut.has_place_for("waist"):
        return cut
    darts = cut.skirt in SHEATHS and "shaping" not in fixed
    return cut.choose({"waist": "seam", **({"shaping": "darts"} if darts else {})})


def has_curved_waist(target: Target, body: Body) -> bool:
    """Return whether the cloth is curved along a line across front and back near the waist, as a seam there makes it.

    Between its seams a panel is developable: its Gaussian curvature, at a vertex 2 pi less the sum of the angles around
    it, is zero however it hangs. Where darts end at a waist seam, or a curved edge is sewn to a straight one, the cloth
    is hollow there, which no dress without that seam is between its side seams. A seam between two straight edges
    leaves no trace, and is not found.

    Args:
        target: The garment; upright.
        body: The wearer.
    """
    waist = measure_wearer(body)
    curvature = _angle_defects(target.vertices, target.faces)
    from_pelvis = target.vertices - body.joint("pelvis")
    sideways = unit((body.joint("left_hip") - body.joint("right_hip"))[None])[0]
    upwards = unit((body.joint("neck") - body.joint("pelvis"))[None])[0]
    above = from_pelvis @ upwards - (waist.waist_height - rest_body(body).joint("pelvis")[1])
    from_middle = np.abs(from_pelvis @ sideways)
    band = np.floor(above / BAND).astype(np.int64) + BANDS // 2
    counted = (from_middle < BETWEEN * waist.waist) & (band >= 0) & (band < BANDS)
    bands = np.bincount(band[counted], weights=curvature[counted], minlength=BANDS)
    lines = bands[:-1] + bands[1:]
    at = int(np.argmin(lines[1:-1])) + 1  # not where the bands end
    return bool(lines[at] < -CURVED and -lines[at] > SHARE * np.abs(bands).sum())


def _angle_defects(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return 2 pi less the sum of the angles around each vertex [rad], shape [vertex_count]; 0 on open contours."""
    angles = np.bincount(faces.ravel(), weights=corner_angles(vertices, faces).ravel(), minlength=len(vertices))
    edges = HalfEdges.of(faces, len(vertices))
    defects = np.where(angles > 0.0, 2.0 * np.pi - angles, 0.0)
    defects[edges.edges[edges.face_counts == 1].ravel()] = 0.0
    return np.asarray(defects)
