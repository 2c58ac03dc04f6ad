"""Deform a graded drape onto a target: repair, Jacobian stage, polish, clearance from body and cloth."""

from __future__ import annotations

import numpy as np

from ...body.exposed import ExposedSurface, penetration_depth
from ...body.projection import project_outside
from ...body.untangling import untangle_outside
from ...garment.garment import Garment
from ...geometry.geometry import gradient_operator, shape_gradients
from ...geometry.intersections import self_intersections
from ...geometry.move_towards import move_towards
from ...run.best import choose_best
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.target import Target
from .acceptance import accept_polish, find_crossing_faces, find_flipped_faces
from .clearance import ProximityCache, enforce_clearance
from .deformation import Deformation
from .jacobian_stage import optimise_jacobians
from .objective import Objective
from .polish import polish_nodes
from .rest_metric import RestMetric
from .settings import DeformSettings
from .strain_limits import limit_strain, smooth_crossings
from .target_repair import PreparedTarget, prepare_target

DEFAULT_DEFORM_SETTINGS = DeformSettings()
"""The settings used where none are given."""

BODY_DEPTH_WARNING_LIMIT = 1e-3
"""Depth in the body above which the user is warned [m]; the pipeline's hard limit."""


BODY_DEPTH_TOLERANCE = 5e-4
"""Depth in the body that is left [m]: half of what a measure allows. The smooth solve reaches its margin within some
tenths; a greater depth means that cloth is in a crease. Only then are creases of the body cut: between intersecting
thighs a triangle is stretched to 2.5 times its length if all steps use the cut, to 1.4 times if only the last does."""


def deform(
    garment: Garment,
    target: Target,
    body: ExposedSurface,
    *,
    settings: DeformSettings = DEFAULT_DEFORM_SETTINGS,
    hooks: Hooks = SILENT_HOOKS,
) -> Deformation:
    """Deform a garment's graded drape onto the target's surface.

    Thesis chapter 4 with each module's **Deviation**. Faces stay, so that the pattern stays the uv map.

    Args:
        garment: The graded drape; its contours are matched with the target's by name.
        target: The surface to be reached.
        body: The wearer's exposed skin; the result is outside it, except cloth pinched between parts of the body.
        settings: Weights and steps.
        hooks: Progress under the name `deform`, and cancellation at every step.

    Raises:
        Cancelled: as soon as the hooks say so.
    """
    hooks.progress("deform", 0.0, "repair of the target")
    nodes = np.ascontiguousarray(garment.nodes, dtype=np.float64)
    faces = np.ascontiguousarray(garment.faces, dtype=np.int64)
    gradient, areas = gradient_operator(garment.rest, faces, len(nodes))
    goal = prepare_target(target, garment, settings.repair)
    metric = RestMetric(faces, garment.panel_of_face, areas, settings.metric_scale)
    inverse = shape_gradients(garment.rest)[:, 1:]
    objective = Objective(nodes, faces, inverse, areas, goal, body.whole, settings)
    hooks.progress("deform", 0.1, "Jacobians")
    stage = optimise_jacobians(nodes, gradient, areas, objective, metric, settings, hooks)
    x, polished = stage.nodes, False
    if settings.polish_iterations > 0:
        finer = polish_nodes(x, faces, gradient, metric, goal, body.whole, settings, hooks)
        x, polished = accept_polish(finer, x, faces, goal)
        allowed = int(find_crossing_faces(nodes, faces).sum())
        smoothed = smooth_crossings(x, gradient, areas, faces, allowed, settings.easing)
        x = smoothed if find_crossing_faces(smoothed, faces).any() else move_towards(smoothed, x, faces)
        eased = limit_strain(x, gradient, areas, faces, settings.easing)
        least = max(allowed, int(find_crossing_faces(x, faces).sum()))
        tried = {"limited": eased, "as it was": x}
        x = choose_best(
            "strain", tried, lambda one: find_crossing_faces(one, faces).sum() if one is eased else least, hooks
        )
    hooks.progress("deform", 0.9, "clearance")
    if settings.clear_body:
        body = body.sparing_pinched
        watch = ProximityCache(faces, body.whole, settings.body_margin)
        x = enforce_clearance(x, gradient, areas, watch, settings.clearance, ease=settings.polish_iterations > 0)
        x = x if penetration_depth(x, faces, body) <= BODY_DEPTH_TOLERANCE else project_outside(x, body, faces)
        x = untangle_outside(x, body, faces)
    flips = (int(find_flipped_faces(nodes, faces, goal).sum()), int(find_flipped_faces(x, faces, goal).sum()))
    crossings = (len(self_intersections(nodes, faces)), len(self_intersections(x, faces)))
    depth = penetration_depth(x, faces, body)
    hooks.progress("deform", 1.0, "done")
    return Deformation(
        nodes=x,
        iterations=stage.iterations,
        losses=stage.losses,
        polished=polished,
        matched=tuple(c.name for c, _ in goal.pairs),
        normals_reversed=goal.reversed,
        normals_unsigned=goal.unsigned,
        spikes=goal.spikes,
        flipped_faces=flips,
        self_intersecting_faces=crossings,
        body_depth=depth,
        warnings=_warnings(garment, target, goal, flips, crossings, depth),
    )


def _warnings(
    garment: Garment,
    target: Target,
    goal: PreparedTarget,
    flips: tuple[int, int],
    crossings: tuple[int, int],
    depth: float,
) -> tuple[str, ...]:
    """Return the warnings to the user, one sentence each."""
    said = []
    matched = {c.name for c, _ in goal.pairs}
    for name in sorted({c.name for c in garment.contours} - matched):
        said.append(f"The contour '{name}' has no trusted counterpart on the scan; that border was left free.")
    for name in sorted({c.name for c in target.contours} - {c.name for c in garment.contours}):
        said.append(f"The scan's contour '{name}' has no counterpart on the garment.")
    if goal.reversed:
        said.append("The scan's normals pointed inwards and were turned.")
    if goal.unsigned:
        said.append("The scan's normals disagree in sign; only their axes were used.")
    if goal.spikes:
        said.append(f"{goal.spikes} outlying points of the scan were moved onto their neighbours.")
    if flips[1] > flips[0]:
        said.append(f"{flips[1]} faces point against the scan's surface.")
    if crossings[1] > crossings[0]:
        said.append(f"{crossings[1]} faces of the detail mesh intersect others ({crossings[0]} in the graded drape).")
    if depth > BODY_DEPTH_WARNING_LIMIT:
        said.append(f"The detail mesh reaches {depth * 1e3:.1f} mm into the body; check the body's fit to the scan.")
    return tuple(said)
