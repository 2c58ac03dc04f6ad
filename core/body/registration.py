"""Fit the built-in body to a body mesh without a skeleton: search heading and pose, then refine."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..geometry.geometry import face_areas, face_normals, signed_volume, vertex_normals
from ..geometry.surface import TriangleSurface
from ..run.errors import BadInput
from ..run.hooks import SILENT_HOOKS, Hooks
from .body import JOINTS, Body
from .competing_starts import POSES, STAGE, SearchSettings, rank_starts, spread_subset
from .fit import FitStage, FitState, Fitter, OrientedPoints, axis_angles_of
from .person_search import list_headings, pose_points, shape_of_stature
from .skinning import skin
from .template import Template, articulate, load_template, rotations_of, transforms_of
from .weight_transfer import transfer_weights

MESH_SEARCH = SearchSettings(
    fine_count=1800,
    kept=(16, 8, 3),
    stages=(
        (FitStage(2, 0.30, 0.15, False, 4),),
        (FitStage(3, 0.30, 0.15, False, 4), FitStage(4, 0.15, 0.15, False, 8)),
        (FitStage(10, 0.10, 0.15, False, 10), FitStage(10, 0.06, 0.10, True, 15)),
        (FitStage(12, 0.05, 0.10, True, 20),),
    ),
)
"""Rounds of a body's mesh, with one point of the template every 3 cm in the last: finer than the joints are
determined."""


@dataclass(frozen=True)
class RegistrationSettings:
    """Describe how a mesh is registered.

    Attributes:
        search: Rounds in which all starts compete.
        surface_count: Number of points of the mesh in the last stages: one every 2 cm, where the plane through a point
            is within a millimetre or two of the surface.
        stages: Stages after the search, with ever more free shape coefficients.
        worst_fit: Largest ratio of RMS to the body's height. People, also dressed, have up to 0.006; a box as tall as a
            person 0.03, a dress alone 0.05, a person head down 0.08, a ball 0.5.
        seed: Number that seeds the choice of points.
    """

    search: SearchSettings = MESH_SEARCH
    surface_count: int = 5000
    stages: tuple[FitStage, ...] = (FitStage(12, 0.025, 0.06, True, 40), FitStage(12, 0.012, 0.04, True, 60))
    worst_fit: float = 0.02
    seed: int = 0


class NotHuman(BadInput):
    """This does not look like a person; check that it is a whole wearer, head to feet, upright, in metres."""

    code = "body.not_human"


def register_body(
    vertices: np.ndarray,
    faces: np.ndarray,
    *,
    name: str = "mesh",
    hooks: Hooks = SILENT_HOOKS,
    settings: RegistrationSettings | None = None,
) -> Body:
    """Fit the built-in body to a mesh of a person: return the mesh with joints, bones and skinning weights.

    Several headings and start poses compete on a few points; the best continue with more. Points are paired both ways
    by position and normal, and shape, pose and place are improved by Gauss-Newton under priors.

    Args:
        vertices: Positions [m], y up, any place and heading, shape [n, 3].
        faces: Triangles, shape [f, 3]; turned outward where they enclose a negative volume.
        name: Part of `Body.source`, which is `mesh:NAME`.
        hooks: For progress and cancelling.
        settings: How to register, or None for the defaults.

    Returns:
        The body. Its vertices are the given ones.

    Raises:
        NotHuman: where no start converges to the mesh.
    """
    settings = settings or RegistrationSettings()
    vertices = np.asarray(vertices, dtype=np.float64)
    faces = np.asarray(faces, dtype=np.int64)
    if not len(faces) or not np.isfinite(vertices).all():
        raise NotHuman(f"The body mesh has no faces or positions that are no numbers. {NotHuman().message}")
    if signed_volume(vertices, faces) < 0:
        faces = faces[:, ::-1]
    if not 0.8 <= np.ptp(vertices[:, 1]) <= 2.6:
        raise NotHuman(f"The body mesh is {np.ptp(vertices[:, 1]):.2f} m high. {NotHuman().message}")
    template = load_template()
    state = _find(template, vertices, faces, settings, hooks)
    rms = _misfit(pose_model(template, state)[0], template.faces, vertices, faces)
    model = body_of_state(template, state, rms)
    require_fit(rms, model, settings.worst_fit)
    weights = transfer_weights(vertices, faces, model.vertices, template.faces, template.weights)
    return replace(model, vertices=vertices, faces=faces, weights=weights, source=f"mesh:{name}")


def require_fit(rms: float, body: Body, worst: float = RegistrationSettings.worst_fit) -> None:
    """Check the distance of a body from the mesh to which it was fitted.

    Args:
        rms: RMS distance of the two [m].
        body: The body.
        worst: Largest accepted RMS over the body's height.

    Raises:
        NotHuman: where the distance is larger.
    """
    if rms > worst * np.ptp(body.rest_vertices[:, 1]):
        raise NotHuman(f"The built-in body stays {1e3 * rms:.0f} mm from the mesh. {NotHuman().message}")


def _find(
    template: Template, vertices: np.ndarray, faces: np.ndarray, settings: RegistrationSettings, hooks: Hooks
) -> FitState:
    """Let all starts compete and return the best fit."""
    rng = np.random.default_rng(settings.seed)
    surface = sample_surface(vertices, faces, settings.surface_count, rng)
    subset = spread_subset(template, settings.search.fine_count, rng)
    shape_count = settings.search.stages[0][0].shape_count
    starts = _starts(template, surface, float(face_areas(vertices, faces).sum()), subset, shape_count)
    state = rank_starts(template, surface, subset, starts, settings.search, hooks)[0][2]
    fine = Fitter(template, subset, surface)
    for i, stage in enumerate(settings.stages):
        hooks.progress(STAGE, 0.9 + 0.05 * i, "fitting shape and pose")
        state = fine.fit(state, stage)
    return state


def _starts(
    template: Template, surface: OrientedPoints, area: float, subset: np.ndarray, shape_count: int
) -> list[FitState]:
    """Return every start: each pose at each heading, scaled to the mesh's area and centred on the mesh."""
    centre = surface.points.mean(axis=0)
    # The area gives the size in every pose; a wrinkled or noisy mesh has too much of it, hence the bounds.
    factor = np.sqrt(area / face_areas(template.vertices, template.faces).sum())
    height = float(np.clip(factor * np.ptp(template.vertices[:, 1]), 1.4, 2.0))
    shape = shape_of_stature(template, height)[:shape_count]
    starts = []
    for angles in POSES.values():
        vectors = np.zeros((24, 3))
        for joint, vector in angles.items():
            vectors[JOINTS.index(joint)] = vector
        for heading in list_headings():
            turned = vectors.copy()
            turned[0] = (0.0, heading, 0.0)
            rotations = rotations_of(turned)
            placed = pose_points(template, shape, rotations, subset)
            starts.append(FitState(shape, rotations, centre - placed.mean(axis=0)))
    return starts


def sample_surface(vertices: np.ndarray, faces: np.ndarray, count: int, rng: np.random.Generator) -> OrientedPoints:
    """Draw points uniformly by area, with their faces' normals."""
    normals, area = face_normals(vertices, faces)
    face = rng.choice(len(faces), count, p=area / area.sum())
    u, v = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    a, b, c = (vertices[faces[face, k]] for k in range(3))
    return OrientedPoints((1 - u) * a + u * (1 - v) * b + u * v * c, normals[face])


def _misfit(model: np.ndarray, model_faces: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the RMS distance [m] of two surfaces, with equal weight of both directions."""
    there = _distance(model, model_faces, vertices, faces)
    back = _distance(vertices, faces, model, model_faces)
    return float(np.sqrt((there**2 + back**2) / 2))


def _distance(vertices: np.ndarray, faces: np.ndarray, others: np.ndarray, other_faces: np.ndarray) -> float:
    """Return the RMS distance [m] from one surface to another."""
    points = sample_surface(vertices, faces, 4000, np.random.default_rng(0)).points
    distance = TriangleSurface(others, other_faces).distance(points)
    return float(np.sqrt((distance**2).mean()))


def body_of_state(template: Template, state: FitState, rms: float, name: str = "scan") -> Body:
    """Return the fitted model itself as a body; `rms` is the distance of the skin to it [m]."""
    rest, joints = template.shaped(state.shape)
    floor = np.array([0.0, rest[:, 1].min(), 0.0])
    rest, joints = rest - floor, joints - floor
    world, posed = articulate(state.rotations, joints, state.translation + floor)
    transforms = transforms_of(world, posed, joints)
    front = world[0] @ np.array([0.0, 0.0, 1.0])
    yaw = np.arctan2(front[0], front[2])
    return Body(
        vertices=skin(rest, template.weights, transforms),
        faces=template.faces,
        joints=posed,
        weights=template.weights,
        transforms=transforms,
        rest_vertices=rest,
        rest_faces=template.faces,
        rest_joints=joints,
        rest_weights=template.weights,
        heading=rotations_of(np.array([0.0, -yaw, 0.0])),
        parameters={
            "shape": state.shape,
            "pose": axis_angles_of(state.rotations),
            "translation": state.translation + floor,
        },
        source=f"scan:{name}",
        fit_rms=rms,
    )


def pose_model(template: Template, state: FitState) -> tuple[np.ndarray, np.ndarray]:
    """Return the fitted model's vertices [m] and unit normals, shape [n, 3] each."""
    rest, joints = template.shaped(state.shape)
    world, posed = articulate(state.rotations, joints, state.translation)
    model = skin(rest, template.weights, transforms_of(world, posed, joints))
    return model, vertex_normals(model, template.faces)
