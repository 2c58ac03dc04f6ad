"""Complete a target below a covering garment with the base pattern's own cloth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...body.exposed import ExposedSurface
from ...body.projection import project_outside
from ...garment.garment import Garment
from ...geometry.connectivity import HalfEdges, shortest_paths
from ...geometry.geometry import vertex_normals
from ...geometry.rim import Rim
from ...geometry.surface import TriangleSurface
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.loop import smoothed_length
from ...scan.contours.target import Contour, Target
from .registration import HiddenCloth, RegistrationSettings, register_coarsely

MIN_HIDDEN_CONTOUR_SHARE = 0.3
"""Share of a template's contour beyond the hidden border from which that contour is hidden, as for a scan. The rest of
a neckline below hair is visible; a base pattern that ends before the border ends there."""


HIDDEN_WAIST_HEIGHT_SHARE = 0.5
"""Share of the height at which its own band holds the base pattern in the height of a hidden waist; the rest is that of
the visible cloth. The bands of three wearers held it 52, 8 and 34 mm above the true waist, of 20 garments of other
simulators 37 mm (standard deviation 36); carried with too short a base pattern's legs, it was 30, 27, 17 mm below."""


def complete_target(worn: Garment, target: Target, skin: ExposedSurface, hooks: Hooks = SILENT_HOOKS) -> Target:
    """Complete a target below a covering garment with the cloth of a base pattern on the same wearer.

    Hidden cloth is assumed to be as in the base pattern: the visible part is registered, and what is beyond its hidden
    border moves with the cloth there, with its own lengths (`HiddenCloth`). Trousers thus keep the rise of their base
    pattern above their visible part. A waist is then placed halfway to where the base pattern's own band holds it, and
    the hem of a top where the whole top has the base pattern's length (`_lift_end`). See ADR 0024 and 0060.

    Args:
        worn: The base pattern on the wearer, contours named.
        target: The visible surface.
        skin: The wearer's exposed skin; hidden cloth is outside it.
        hooks: Progress and cancellation.

    Returns:
        The target with a separate surface for the hidden part. The contours at its ends have the template's names and
        are trusted, so that a fit uses them. The target itself where nothing of it is hidden.
    """
    ends = [contour for contour in worn.contours if _is_hidden(contour, target)]
    if target.hidden is None or not ends:
        return target
    settings = RegistrationSettings(hidden=HiddenCloth())
    seen, border = TriangleSurface(target.vertices, target.faces), Rim.between(target.faces, target.hidden)
    nodes = register_coarsely(worn, target, settings, hooks)
    beyond = border.is_ahead(seen, seen.closest(nodes))
    lost = [end for end in ends if beyond[end.vertices].all()]
    lifts = [(end, lift) for end in lost if (lift := _lift_end(worn, nodes, beyond, end))]
    if lifts:
        nodes = register_coarsely(worn, _hold_ends(target, nodes, lifts), settings, hooks)
    nodes = project_outside(nodes, skin, worn.faces)
    beyond = border.is_ahead(seen, seen.closest(nodes))
    ends = [end for end in ends if beyond[end.vertices].mean() > MIN_HIDDEN_CONTOUR_SHARE]
    links = HalfEdges.of(worn.faces, len(nodes)).adjacency
    for end in ends:  # where a part of the contour is visible, the strip along it is on the scan
        rim = np.bincount(end.vertices, minlength=len(nodes))
        beyond |= (rim + links @ rim) > 0
    inner = worn.faces[beyond[worn.faces].all(axis=1)]
    _, piece = HalfEdges.of(inner, len(nodes)).vertex_pieces
    inner = inner[np.isin(piece[inner[:, 0]], [piece[end.vertices[0]] for end in ends])]
    return _join(target, nodes, inner, ends) if len(inner) else target


def _is_hidden(contour: Contour, target: Target) -> bool:
    """Check whether a template's contour is hidden on the target, or missing because it is hidden."""
    other = target.contour(contour.name)
    return other is None or other.hidden


def _hold_ends(target: Target, nodes: np.ndarray, lifts: list[tuple[Contour, float]]) -> Target:
    """Return the target with a trusted contour for each hidden end, at the carried nodes [m] raised by its lift [m]."""
    points = np.concatenate([nodes[end.vertices] + [0.0, lift, 0.0] for end, lift in lifts])
    first = len(target.vertices) + np.cumsum([0] + [len(end.vertices) for end, _ in lifts])
    fixed = tuple(
        replace(end, vertices=start + np.arange(len(end.vertices)), trusted=True, hidden=False)
        for (end, _), start in zip(lifts, first, strict=False)
    )
    names = [end.name for end in fixed]
    hidden = np.zeros(len(target.vertices), dtype=bool) if target.hidden is None else target.hidden
    return replace(
        target,
        vertices=np.concatenate([target.vertices, points]),
        normals=np.concatenate([target.normals, np.zeros_like(points)]),
        contours=(*(contour for contour in target.contours if contour.name not in names), *fixed),
        hidden=np.append(hidden, np.zeros(len(points), dtype=bool)),
    )


def _lift_end(worn: Garment, nodes: np.ndarray, unseen: np.ndarray, end: Contour) -> float:
    """Return the distance of a hidden end above the place to which visible cloth carried it [m].

    A waist: `HIDDEN_WAIST_HEIGHT_SHARE` of the way back to where its own band holds it. The hem of a top: the
    difference by which the visible way down to it is longer than the base pattern's, for a top too small for its wearer
    is lowered by that in dressing; at most half of the hidden way: a tucked-in top continues below the waistband.
    """
    if end.name == "waist":
        return HIDDEN_WAIST_HEIGHT_SHARE * float((worn.nodes[end.vertices, 1] - nodes[end.vertices, 1]).mean())
    neck = next((contour for contour in worn.contours if contour.name == "neck"), None)
    if end.name != "hem" or neck is None:
        return 0.0
    longer, hidden = _measure_downward_paths(worn, nodes, unseen, neck.vertices)
    return float(np.clip(longer[end.vertices].mean(), 0.0, 0.5 * hidden[end.vertices].mean()))


def _measure_downward_paths(
    worn: Garment, nodes: np.ndarray, unseen: np.ndarray, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Compute lengths along the shortest flat way from some nodes to each, [node_count] each: excess and hidden [m].

    The excess is the length of the way's visible part on the nodes less its flat length; the hidden one is flat.
    """
    count, edges = len(nodes), HalfEdges.of(worn.faces, len(nodes))
    sides = np.linalg.norm(np.roll(worn.rest, -1, axis=1) - worn.rest, axis=2).ravel()
    flat = np.bincount(edges.edge, sides) / edges.face_counts  # both sides of a gathered seam count
    length, before, _ = shortest_paths(edges, flat, start)
    longer, hidden = np.zeros(count), np.zeros(count)
    for node in np.argsort(length):
        last = before[node]
        if last < 0:
            continue
        step, is_hidden = length[node] - length[last], unseen[node] and unseen[last]
        longer[node] = longer[last] + (0.0 if is_hidden else np.linalg.norm(nodes[node] - nodes[last]) - step)
        hidden[node] = hidden[last] + (step if is_hidden else 0.0)
    return longer, hidden


def _join(target: Target, nodes: np.ndarray, faces: np.ndarray, ends: list[Contour]) -> Target:
    """Return the target with some faces of the template added."""
    chosen, numbered = np.unique(faces, return_inverse=True)
    first = len(target.vertices)
    place = np.full(len(nodes), -1, dtype=np.int64)
    place[chosen] = first + np.arange(len(chosen))
    vertices = np.concatenate([target.vertices, nodes[chosen]])
    hidden = numbered.reshape(-1, 3)
    names = tuple(end.name for end in ends)
    added = tuple(
        replace(end, vertices=place[end.vertices], length=smoothed_length(nodes[end.vertices]), trusted=True)
        for end in ends
    )
    kept = tuple(contour for contour in target.contours if contour.name not in names)
    return replace(
        target,
        vertices=vertices,
        faces=np.concatenate([target.faces, first + hidden]),
        normals=np.concatenate([target.normals, vertex_normals(nodes[chosen], hidden)]),
        contours=tuple(sorted((*kept, *added), key=lambda contour: contour.name)),
        hidden=None,
        origin=None,
    )
