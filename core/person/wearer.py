"""Find the wearer of a scan that is a body, or on which somebody marked what is cloth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ..body import Body, NotHuman, PersonSettings, fit_person, refit_person, register_body
from ..body.registration import require_fit
from ..hooks import SILENT, Hooks
from ..mesh import vertex_normals
from ..scan import Scan
from ..scan.raw import RawScan
from .diffusion import link_points
from .limbs import place_on_body
from .part import CLOTH, PARTS
from .points import sample_person
from .separate import predict_parts, weigh

IS_CLOTH = np.isin(PARTS, CLOTH)
"""Which columns of a posterior are cloth."""

LEAST = 1e-6
"""Probability that the marks leave at least to any part that they allow."""


def fit_wearer(scan: Scan, cloth: np.ndarray | None, hooks: Hooks = SILENT) -> Body:
    """Find the wearer of a scan: a body's mesh is registered, below marked cloth he is found as `separate` finds him.

    Nobody is refused for being scanned in part: who marked the clothes has seen that it is a person.

    Args:
        scan: The body, or the dressed person.
        cloth: True at vertices of any garment, bool, shape [vertex_count]; None: the scan is a body's.
        hooks: Progress and cancellation.

    Returns:
        The body. Below cloth it is the fitted model, and `fit_rms` the distance of the skin to it.

    Raises:
        NotHuman: where nothing is skin, or no body comes near it.
    """
    if cloth is None:
        return register_body(scan.vertices, scan.faces, name=scan.name, hooks=hooks)
    if cloth[scan.faces].all():
        raise NotHuman(f"Nothing of the mesh is skin. {NotHuman().message}")
    every = np.arange(len(scan.vertices))
    normals = vertex_normals(scan.vertices, scan.faces)
    raw = RawScan(scan.vertices, scan.faces, normals, True, None, None, every, every, scan.name)
    fit = fit_person(raw.points, raw.normals, True, hooks, PersonSettings(refuses=False))
    points = sample_person(raw, fit)
    marked = cloth[cKDTree(raw.points).query(points.positions)[1]]
    told, _ = predict_parts(points, fit, link_points(points.positions, points.normals))
    posterior = np.where(marked[:, None] == IS_CLOTH, told + LEAST, 0.0)
    posterior /= posterior.sum(axis=1, keepdims=True)
    fit = refit_person(fit, points.positions, points.normals, weigh(posterior), hooks)
    weights = weigh(posterior, place_on_body(points, fit.body))
    fit = refit_person(fit, points.positions, points.normals, weights, hooks)
    require_fit(fit.skin_rms, fit.body)
    return replace(fit.body, source=f"scan:{scan.name}")
