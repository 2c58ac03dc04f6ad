"""Find the wearer of a scan that is a body, or has its cloth marked."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..body.dress_form import register_wearer
from ..body.person import PersonSettings, fit_person, refit_person
from ..body.registration import NotHuman, require_fit
from ..geometry.geometry import vertex_normals
from ..run.hooks import SILENT_HOOKS, Hooks
from ..scan.raw import RawScan
from ..scan.scan import Scan
from .diffusion import link_points
from .limbs import place_on_body
from .part import CLOTH, PARTS
from .points import sample_person
from .separate import predict_parts, to_point_weights
from .undeclared import UndeclaredGarment, find_undeclared_garments

CLOTH_COLUMNS = np.isin(PARTS, CLOTH)
"""Which columns of a posterior are cloth."""

MIN_ALLOWED_PROBABILITY = 1e-6
"""Probability added to every part that the mark of a sample allows, so that rows can always be scaled to sum to 1."""


@dataclass(frozen=True)
class FoundWearer:
    """Describe the wearer of a garment.

    Attributes:
        body: The body.
        undeclared: Garments that the marks leave to the skin; None where the body does not follow from marks.
    """

    body: Body
    undeclared: tuple[UndeclaredGarment, ...] | None = None


def fit_wearer(
    scan: Scan, cloth: np.ndarray | None, hooks: Hooks = SILENT_HOOKS, labels: np.ndarray | None = None
) -> FoundWearer:
    """Find the wearer of a scan: register a body's mesh, or fit the body below marked cloth, as `separate` does.

    Scans of part of a person are accepted here, since the marks show that it is a person.

    Args:
        scan: The body, or the dressed person.
        cloth: True at vertices of any garment, bool, shape [vertex_count]; None: the scan is a body's.
        hooks: Progress and cancellation.
        labels: Label of each vertex, numbers or texts, shape [vertex_count], to name garments among the skin, or None.

    Returns:
        The wearer. Below cloth the body is the fitted model, and its `fit_rms` the distance of the skin to it.

    Raises:
        NotHuman: where nothing is skin, or no body comes near it.
    """
    if cloth is None:
        return FoundWearer(register_wearer(scan.vertices, scan.faces, name=scan.name, hooks=hooks))
    if cloth[scan.faces].all():
        raise NotHuman(f"Nothing of the mesh is skin. {NotHuman().message}")
    every = np.arange(len(scan.vertices))
    normals = vertex_normals(scan.vertices, scan.faces)
    raw = RawScan(scan.vertices, scan.faces, normals, True, None, None, every, every, scan.name)
    bare = fit_person(raw.points, raw.normals, True, hooks, PersonSettings(refuses=False))
    points = sample_person(raw, bare)
    rows = cKDTree(raw.points).query(points.positions)[1]
    marked = cloth[rows]
    known, _ = predict_parts(points, bare, link_points(points.positions, points.normals))
    posterior = _restrict_to_marks(marked, known)
    fit = refit_person(bare, points.positions, points.normals, to_point_weights(posterior), hooks)
    weights = to_point_weights(posterior, place_on_body(points, fit.body))
    fit = refit_person(fit, points.positions, points.normals, weights, hooks)
    require_fit(fit.skin_rms, fit.body)

    def fit_below(chosen: np.ndarray) -> Body:
        """Fit the body below what is cloth, bool, shape [n]."""
        return refit_person(
            bare, points.positions, points.normals, to_point_weights(_restrict_to_marks(chosen, known)), hooks
        ).body

    undeclared = find_undeclared_garments(points, known, marked, None if labels is None else labels[rows], fit_below)
    return FoundWearer(replace(fit.body, source=f"scan:{scan.name}"), undeclared)


def _restrict_to_marks(marked: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """Return a posterior, shape [n, part_count], by which just what is marked, bool, shape [n], is cloth."""
    posterior = np.where(marked[:, None] == CLOTH_COLUMNS, predicted + MIN_ALLOWED_PROBABILITY, 0.0)
    return np.asarray(posterior / posterior.sum(axis=1, keepdims=True))
