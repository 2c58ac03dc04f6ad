"""Fit pattern and nodes on the target together, until flat panels and the cloth on the surface are isometric."""

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

FIT_ISOMETRY_SETTINGS = IsometrySettings(start_cost_band=1.0, start_cost_hidden=1.0)
"""As in `IsometrySettings`, but bands keep the graded shape: the place of their long seams on a smooth surface is not
visible, and without it a stiff skirt's waistband lost half its width to the skirt. So does cloth that a hanging arm
hides: fixed in the sagging drape, a T-shirt's armholes were 8 % too long and its sleeves 17 % too short."""

CONTROL_POINT_TOLERANCE = 3e-4
"""Largest motion of a control point in one step below which the pattern rests [m]: far below the remaining error."""


def choose_isometry_settings(case: Case) -> IsometrySettings:
    """Return the settings of a case's fit: Gauss-Newton steps where its seams may be far from their places.

    On the registered cloth these converge to the noise of the registration, which small steps do not reach: pattern
    files other than tops are fitted by small steps (ADR 0067); the error of other patterns exceeds that noise.
    """
    return FIT_ISOMETRY_SETTINGS.by_newton() if case.has_far_seams else FIT_ISOMETRY_SETTINGS


def fit_isometry(
    garment: Garment,
    registered: np.ndarray,
    target: Target,
    body: Body,
    base: Pattern,
    settings: IsometrySettings | None = None,
    hooks: Hooks = SILENT_HOOKS,
) -> Garment:
    """Fit the pattern and slide the cloth over the target until the two are isometric.

    See `slide_seams` and `Isometry`. The cloth's strain is that of the drape with the coarse mesh's cut folds.

    Args:
        garment: The graded pattern's mesh, nodes at its drape, contours named.
        registered: The same nodes on the target [m], shape [node_count, 3].
        target: The scan's surface with named contours.
        body: The wearer, on whom the contours are named.
        base: The template, which gives symmetry and proportions.
        settings: Weights and steps.
        hooks: Progress and cancellation.

    Returns:
        A mesh of `settings.vertices` vertices of the fitted pattern, its nodes on the target.
    """
    settings = settings or FIT_ISOMETRY_SETTINGS
    fitted, strain = mesh_on_target(garment, registered, settings)
    problem = Isometry.of(fitted, target, body, base, strain, settings)

    def tell(step: int) -> None:
        hooks.progress("fit", 0.2 * step / settings.steps, "sliding the seams into place")

    return solve_isometry(problem, fitted, CONTROL_POINT_TOLERANCE, tell)


def mesh_on_target(
    garment: Garment, registered: np.ndarray, settings: IsometrySettings = FIT_ISOMETRY_SETTINGS
) -> tuple[Garment, np.ndarray]:
    """Return a coarse mesh of a graded pattern, and the estimated strain of its cloth on the target.

    Args:
        garment: The graded pattern's mesh, nodes at its drape.
        registered: The same nodes on the target [m], shape [node_count, 3].
        settings: Vertices and the bound on strain.

    Returns:
        The coarse mesh with its nodes on the target, and the strain of its faces, shape [face_count, 2, 2].
    """
    coarse = mesh_pattern(garment.pattern, min(settings.vertices, len(registered)))
    fitted = coarse.at(resample(garment, registered, coarse))
    return fitted, strain_on_target(fitted, garment, registered, settings.max_strain)


def strain_on_target(
    coarse: Garment, drape: Garment, registered: np.ndarray, max_strain: float = FIT_ISOMETRY_SETTINGS.max_strain
) -> np.ndarray:
    """Return the estimated strain of the cloth of a coarse mesh on the target, shape [face_count, 2, 2].

    Args:
        coarse: The coarse mesh, nodes on the target.
        drape: A fine mesh of the same pattern, nodes at its drape.
        registered: The fine mesh's nodes on the target [m], shape [node_count, 3].
        max_strain: Bound to which the drape's strain is clipped.
    """
    strain = clamp_stretch(coarse, drape, max_strain) @ subgrid_stretch(coarse, drape, registered)
    return np.asarray(0.5 * (strain + np.swapaxes(strain, 1, 2)))
