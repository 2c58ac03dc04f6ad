"""Fit the built-in body to a dress form: a solid trunk without head and hands, with stumps of neck, arms and legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.connectivity import HalfEdges, find_components
from ..geometry.geometry import signed_volume, vertex_areas
from ..geometry.surface import TriangleSurface
from ..run.hooks import SILENT_HOOKS, Hooks
from .body import DRESS_FORM_SOURCE, JOINTS, Body
from .competing_starts import rank_starts
from .fit import FitState, Fitter, OrientedPoints
from .girths import MIN_LIMB_GIRTH
from .person_search import list_headings, pose_points, shape_of_stature
from .registration import NotHuman, RegistrationSettings, body_of_state, pose_model, register_body, sample_surface
from .template import Template, load_template, rotations_of
from .weight_transfer import transfer_weights

TRUNK_JOINTS = ("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar")
"""Joints whose bones a dress form has; what it has of neck, arms and legs are stumps of any length."""

START_STATURES = (1.55, 1.75)
"""Statures that the search starts from [m]: forms are made for adults."""

ARM_ANGLE = 0.9
"""Angle by which the arms hang below the horizontal in the start [rad]: between those of forms with stumps of arms."""

LID_HEIGHT = 0.02
"""Height of the lowest and the highest strip whose level faces are the form's base and the lid of its neck [m]."""

LEVEL_COSINE = 0.9
"""Least absolute cosine between a face's normal and the vertical for the face to be level [1]: 26 degrees."""

MAX_TRUNK_DISTANCE = 0.015
"""Distance up to which a point of one surface lies on the other [m]: forms are smoothed and padded."""

MIN_FORM_SHARE = 0.8
"""Least share of the form that lies on the model [1]: the lids of arms and legs are less than a fifth."""

MIN_TRUNK_SHARE = 0.95
"""Least share of the model's trunk that lies on the form [1]. Of forms it is 0.97 to 0.99, of an egg of a trunk's size
0.92, of a cylinder 0.81, of a box 0.75."""


def register_wearer(
    vertices: np.ndarray, faces: np.ndarray, *, name: str = "mesh", hooks: Hooks = SILENT_HOOKS
) -> Body:
    """Fit the built-in body to the mesh of a wearer: a person, or a dress form.

    Args:
        vertices: Positions [m], y up, shape [n, 3].
        faces: Triangles, shape [f, 3].
        name: Part of `Body.source`, which is `mesh:NAME` or `form:NAME`.
        hooks: For progress and cancelling.

    Raises:
        NotHuman: where it is neither.
    """
    try:
        return register_body(vertices, faces, name=name, hooks=hooks)
    except NotHuman:
        form = register_dress_form(vertices, faces, name, hooks) if is_solid(vertices, faces) else None
        if form is None:
            raise
        return form


def is_solid(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Check whether a mesh is closed but for one opening at most, as a form on its stand; garments have two or more."""
    if not len(faces) or not np.isfinite(vertices).all():
        return False
    edges = HalfEdges.of(faces, len(vertices))
    tail, head = edges.tail[edges.border], edges.head[edges.border]
    _, piece = find_components(len(vertices), tail, head)
    lengths = np.bincount(piece[tail], np.linalg.norm(vertices[head] - vertices[tail], axis=1))
    return bool((lengths > MIN_LIMB_GIRTH).sum() <= 1)


def register_dress_form(
    vertices: np.ndarray, faces: np.ndarray, name: str = "mesh", hooks: Hooks = SILENT_HOOKS
) -> Body | None:
    """Fit the trunk of the built-in body to a dress form; its legs are straight below it, its arms hang aside.

    Args:
        vertices: Positions [m], y up, shape [n, 3].
        faces: Triangles, shape [f, 3].
        name: Part of `Body.source`.
        hooks: For progress and cancelling.

    Returns:
        The body, its vertices the given ones and its bones those of a whole person; None where it is no form.
    """
    settings, template = RegistrationSettings(), load_template()
    rng = np.random.default_rng(settings.seed)
    if signed_volume(vertices, faces) < 0:
        faces = faces[:, ::-1]
    surface = _without_lids(sample_surface(vertices, faces, settings.surface_count, rng))
    trunk = np.flatnonzero(template.weights[:, [JOINTS.index(name) for name in TRUNK_JOINTS]].sum(axis=1) > 0.5)
    area = vertex_areas(template.vertices, template.faces)[trunk]
    subset = rng.choice(trunk, min(settings.search.fine_count, len(trunk)), replace=False, p=area / area.sum())
    shape_count = settings.search.stages[0][0].shape_count
    starts = [
        start
        for stature in START_STATURES
        for start in _find_starts(template, subset, surface.points.mean(axis=0), (stature, shape_count))
    ]
    state = rank_starts(template, surface, subset, starts, settings.search, hooks)[0][2]
    fine = Fitter(template, subset, surface)
    for stage in settings.stages:
        state = fine.fit(state, stage)
    state = replace(state, rotations=_straighten(state.rotations))
    model, _ = pose_model(template, state)
    there = TriangleSurface(model, template.faces).distance(surface.points)
    back = TriangleSurface(vertices, faces).distance(model[subset])
    shares = ((one < MAX_TRUNK_DISTANCE).mean() for one in (there, back))
    if any(share < least for share, least in zip(shares, (MIN_FORM_SHARE, MIN_TRUNK_SHARE), strict=True)):
        return None
    body = body_of_state(template, state, float(np.sqrt((there[there < MAX_TRUNK_DISTANCE] ** 2).mean())))
    weights = transfer_weights(vertices, faces, body.vertices, template.faces, template.weights)
    return replace(body, vertices=vertices, faces=faces, weights=weights, source=f"{DRESS_FORM_SOURCE}{name}")


def _without_lids(surface: OrientedPoints) -> OrientedPoints:
    """Return the points of a form that are not on its base or on the lid of its neck."""
    height, level = surface.points[:, 1], np.abs(surface.normals[:, 1]) > LEVEL_COSINE
    end = (height < height.min() + LID_HEIGHT) | (height > height.max() - LID_HEIGHT)
    return surface.take(np.flatnonzero(~(end & level)))


def _straighten(rotations: np.ndarray) -> np.ndarray:
    """Return joint rotations, shape [24, 3, 3], with the legs straight below the trunk and the arms as in the start."""
    straight = rotations_of(_limb_angles())
    kept = np.isin(JOINTS, (*TRUNK_JOINTS, "neck", "head"))
    return np.where(kept[:, None, None], rotations, straight)


def _limb_angles() -> np.ndarray:
    """Return the start's axis-angle of each joint [rad], shape [24, 3]."""
    angles = np.zeros((len(JOINTS), 3))
    angles[JOINTS.index("left_shoulder"), 2] = -ARM_ANGLE
    angles[JOINTS.index("right_shoulder"), 2] = ARM_ANGLE
    return angles


def _find_starts(template: Template, subset: np.ndarray, centre: np.ndarray, size: tuple[float, int]) -> list[FitState]:
    """Return upright bodies at every heading, of a stature [m] by so many coefficients, centred on the form."""
    stature, shape_count = size
    shape = shape_of_stature(template, stature)[:shape_count]
    starts = []
    for heading in list_headings():
        angles = _limb_angles()
        angles[0, 1] = heading
        rotations = rotations_of(angles)
        placed = pose_points(template, shape, rotations, subset)
        starts.append(FitState(shape, rotations, centre - placed.mean(axis=0)))
    return starts
