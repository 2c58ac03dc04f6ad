"""Complete a target that goes on below another garment: the hidden part is the base pattern's own cloth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..body import ExposedSurface, project_outside
from ..hooks import SILENT, Hooks
from ..mesh import HalfEdges, Rim, TriangleSurface, vertex_normals
from ..pattern import Garment
from ..segment import Contour, Target, smoothed_length
from .registration import HiddenCloth, RegistrationSettings, register_coarsely

AHEAD = 0.3
"""Share of a template's contour that lies ahead of the hidden border from which that contour is hidden: the share from
which a scan's is. A neckline below hair is seen for the rest; a base pattern that ends before the border ends there."""


def complete_target(worn: Garment, target: Target, skin: ExposedSurface, hooks: Hooks = SILENT) -> Target:
    """Complete a target below what covers it with the cloth of a base pattern that is worn by the same wearer.

    What is hidden can only be guessed, and is guessed as the base pattern has it: the visible part is registered, and
    what lies beyond its hidden border is carried along with the cloth there, with its own lengths (`HiddenCloth`).
    So trousers keep the rise of their base pattern above what is seen of them. The decision is ADR 0024.

    Args:
        worn: The base pattern on the wearer, contours named.
        target: What is seen.
        skin: The wearer's exposed skin; hidden cloth lies outside it.
        hooks: Progress and cancellation.

    Returns:
        The target joined by a surface of its own for what is hidden. The contours at which that ends have the names of
        the template's and are trusted: a fit may take them for the garment's. The target itself where nothing of it is
        hidden.
    """
    ends = [contour for contour in worn.contours if _is_hidden(contour, target)]
    if target.hidden is None or not ends:
        return target
    nodes = register_coarsely(worn, target, RegistrationSettings(hidden=HiddenCloth()), hooks)
    nodes = project_outside(nodes, skin, worn.faces)
    seen = TriangleSurface(target.vertices, target.faces)
    beyond = Rim.between(target.faces, target.hidden).lies_ahead(seen, seen.closest(nodes))
    ends = [end for end in ends if beyond[end.vertices].mean() > AHEAD]
    links = HalfEdges.of(worn.faces, len(nodes)).adjacency
    for end in ends:  # where a part of it is seen, the strip along it lies on the scan
        rim = np.bincount(end.vertices, minlength=len(nodes))
        beyond |= (rim + links @ rim) > 0
    inner = worn.faces[beyond[worn.faces].all(axis=1)]
    _, piece = HalfEdges.of(inner, len(nodes)).vertex_pieces
    inner = inner[np.isin(piece[inner[:, 0]], [piece[end.vertices[0]] for end in ends])]
    return _join(target, nodes, inner, ends) if len(inner) else target


def _is_hidden(contour: Contour, target: Target) -> bool:
    """Check whether a template's contour is one that the target hides, or has not because it is hidden."""
    other = target.contour(contour.name)
    return other is None or other.hidden


def _join(target: Target, nodes: np.ndarray, faces: np.ndarray, ends: list[Contour]) -> Target:
    """Return the target with some faces of the template beside it."""
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
