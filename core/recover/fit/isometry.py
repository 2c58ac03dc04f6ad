"""Find pattern and place on the target together: flat panels and the cloth on the surface, isometric to each other."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.resampling import resample
from ...garment.sewing import mesh_pattern
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.target import Target
from ..case import Case
from ..grade.isometry import Isometry, IsometrySettings
from ..grade.sliding import solve_isometry
from ..grade.strain import clamp_stretch, subgrid_stretch

FIT_ISOMETRY_SETTINGS = IsometrySettings(stay_band=1.0, stay_hidden=1.0)
"""As `IsometrySettings` says; and bands keep the graded shape: where their long seams lie on a smooth surface cannot be
seen, and without it a stiff skirt's waistband lost half its width to the skirt. So does what a hanging arm hides: with
these nodes held where the drape sagged to, a T-shirt's armholes came out 8 % too long and its sleeves 17 % too
short."""

CONTROL_POINT_TOLERANCE = 3e-4
"""Largest motion of a control point in one step below which the pattern rests [m]: far less than the error that
remains."""


def choose_isometry_settings(case: Case) -> IsometrySettings:
    """Return how a case's pattern is fitted: by Gauss-Newton steps where its seams may be far from their places.

    On the registered cloth these come to rest in what the registration has for noise, from which creeping steps stay
    away: a maker's own base pattern is fitted by those, unless it is a top (ADR 0067); what others are off is more than
    that noise.
    """
    return FIT_ISOMETRY_SETTINGS.by_newton() if case.has_far_seams else FIT_ISOMETRY_SETTINGS


def fit_isometry(
    garment: Garment,
    registered: np.ndarray,
    target: Target,
    body: Body,
    like: Pattern,
    settings: IsometrySettings | None = None,
    hooks: Hooks = SILENT_HOOKS,
) -> Garment:
    """Fit the pattern and slide the cloth over the target until the two are isometric.

    Registration knows the surface to a millimetre, but not where on it a seam lies. A developable panel can only be
    bent, so the seams have to lie where the target's Gaussian curvature is: at the waist, round the arm. `Isometry`
    tells what is minimised; the cloth's strain is that of the drape, and what the coarse mesh cuts off its folds.

    Args:
        garment: The graded pattern's mesh, nodes at its drape, contours named.
        registered: The same nodes on the target [m], shape [node_count, 3].
        target: The scan's surface with named contours.
        body: The wearer, on whom the contours are named.
        like: The template: tells symmetry and proportions.
        settings: How.
        hooks: Progress and cancellation.

    Returns:
        A mesh of `settings.vertices` vertices of the fitted pattern, its nodes on the target.
    """
    settings = settings or FIT_ISOMETRY_SETTINGS
    fitted, strain = mesh_on_target(garment, registered, settings)
    problem = Isometry.of(fitted, target, body, like, strain, settings)

    def tell(step: int) -> None:
        hooks.progress("fit", 0.2 * step / settings.steps, "sliding the seams into place")

    return solve_isometry(problem, fitted, CONTROL_POINT_TOLERANCE, tell)


def mesh_on_target(
    garment: Garment, registered: np.ndarray, settings: IsometrySettings = FIT_ISOMETRY_SETTINGS
) -> tuple[Garment, np.ndarray]:
    """Mesh a graded pattern coarsely, and say by how much its cloth on the target is believed to be strained.

    Args:
        garment: The graded pattern's mesh, nodes at its drape.
        registered: The same nodes on the target [m], shape [node_count, 3].
        settings: How.

    Returns:
        The coarse mesh with its nodes on the target, and the strain of its faces, shape [face_count, 2, 2].
    """
    coarse = mesh_pattern(garment.pattern, min(settings.vertices, len(registered)))
    fitted = coarse.at(resample(garment, registered, coarse))
    return fitted, strain_on_target(fitted, garment, registered, settings.believed)


def strain_on_target(
    laid: Garment, drape: Garment, registered: np.ndarray, believed: float = FIT_ISOMETRY_SETTINGS.believed
) -> np.ndarray:
    """Return by how much the cloth of a coarse mesh on the target is believed to be strained, shape [face_count, 2, 2].

    Args:
        laid: The coarse mesh, nodes on the target.
        drape: A fine mesh of the same pattern, nodes at its drape.
        registered: The fine mesh's nodes on the target [m], shape [node_count, 3].
        believed: Strain of the drape up to which its cloth is believed.
    """
    strain = clamp_stretch(laid, drape, believed) @ subgrid_stretch(laid, drape, registered)
    return np.asarray(0.5 * (strain + np.swapaxes(strain, 1, 2)))
