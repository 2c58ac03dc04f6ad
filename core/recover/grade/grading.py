"""Grade a base pattern: compute new control points from a template draped on the wearer and the target."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...body.body import Body
from ...garment.control import map_controls
from ...garment.curves import panel_area
from ...garment.errors import PanelCrossing, PanelDegenerate
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.seams import equalise_seams
from ...garment.validity import check_outline
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.target import Target
from .armpits import Armpits
from .distances import ContourMeasure, compare_contours
from .flattening import FlatteningSettings, fit_control_points, stretch_between
from .registration import RegistrationSettings, register_coarsely


@dataclass(frozen=True)
class GradeSettings:
    """Describe the grading.

    Attributes:
        registration: The coarse registration in 3D.
        flattening: The fit of the control points.
        least_area: Least share of its area that a panel keeps in one grading; otherwise the step is shortened.
        back_offs: Number of halvings of the step before the pattern is left unchanged.
    """

    registration: RegistrationSettings = field(default_factory=RegistrationSettings)
    flattening: FlatteningSettings = field(default_factory=FlatteningSettings)
    least_area: float = 0.05
    back_offs: int = 4


@dataclass(frozen=True)
class Grading:
    """Describe the result of grading.

    Attributes:
        pattern: The base pattern with new control points; seams equal within 1e-6 m.
        garment: The base garment's mesh, flat vertices moved along, nodes registered: a start for the next drape.
        contours: Distance along the skeleton and circumferences, per contour that both garments have.
        share: 1, or less where the step was shortened to keep panels from folding.
        warnings: Warnings to the user, one sentence each.
    """

    pattern: Pattern
    garment: Garment
    contours: tuple[ContourMeasure, ...]
    share: float
    warnings: tuple[str, ...]


def grade_pattern(
    garment: Garment,
    target: Target,
    body: Body,
    *,
    settings: GradeSettings | None = None,
    hooks: Hooks = SILENT_HOOKS,
) -> Grading:
    """Move the control points of a base pattern so that its drape takes the target's size and proportions.

    Thesis 3.2.3 moves only points of open curves, by contours' distances along the bones and circumferences.

    **Deviation**: the same measures are taken everywhere. The draped template is first registered coarsely to the
    target, open contour on open contour; this transfers the axial distances and circumferences of all contours, and
    also girths in between, straps and the shape of necklines. Every flat face is then to stretch as its 3D face did;
    the nearest control points within symmetry and with equal seams are the graded pattern.

    Args:
        garment: The template draped on the wearer, contours named.
        target: The surface to reach, contours named.
        body: The wearer of both.
        settings: Settings of registration and fit.
        hooks: Progress and cancellation.
    """
    settings = settings or GradeSettings()
    contours = compare_contours((garment.nodes, garment.contours), (target.vertices, target.contours), body)
    moved = register_coarsely(garment, target, settings.registration, hooks, Armpits.of(garment, body))
    hooks.progress("grade", 0.8, "flattening")
    stretch = stretch_between(garment, moved, settings.flattening)
    points = fit_control_points(garment, stretch, settings.flattening)
    pattern, share = step_without_folds(garment.pattern, points, settings)
    placed = garment.nodes + share * (moved - garment.nodes)
    graded = replace(move_pattern(garment, pattern), nodes=placed)
    hooks.progress("grade", 1.0, "graded")
    return Grading(pattern, graded, contours, share, _warnings(garment, target, share))


def move_pattern(garment: Garment, pattern: Pattern) -> Garment:
    """Move a garment's flat mesh along with its control points; faces and nodes stay."""
    uv = garment.uv + map_controls(garment).apply(pattern.points - garment.pattern.points)
    return replace(garment, pattern=pattern, uv=uv)


def step_without_folds(pattern: Pattern, points: np.ndarray, settings: GradeSettings) -> tuple[Pattern, float]:
    """Step towards the wanted points as far as every panel stays simple and counter-clockwise, with equal seams."""
    share = 1.0
    for _ in range(settings.back_offs):
        trial = pattern.with_points(pattern.points + share * (points - pattern.points))
        graded = equalise_seams(trial, base=pattern)
        if is_sound(graded, pattern, settings.least_area):
            return graded, share
        share /= 2
    return pattern, 0.0


def is_sound(graded: Pattern, base: Pattern, least_area: float = 0.05) -> bool:
    """Return whether no panel crosses itself, runs clockwise or has less than a share of its former area."""
    try:
        for panel, before in zip(graded.panels, base.panels, strict=True):
            check_outline(panel)
            if not panel_area(panel) > least_area * panel_area(before):
                return False
    except (PanelCrossing, PanelDegenerate):
        return False
    return True


def _warnings(garment: Garment, target: Target, share: float) -> tuple[str, ...]:
    names, others = ({c.name for c in contours} for contours in (garment.contours, target.contours))
    warnings = [
        f"the target has no contour '{name}' to grade to; check the garment's category."
        for name in sorted(names - others)
    ]
    warnings += [
        f"the template has no contour '{name}'; check the garment's category." for name in sorted(others - names)
    ]
    if share < 1.0:
        warnings.append(
            f"only {100 * share:.0f} % of the grading was done, or panels would fold over; choose a closer template."
        )
    return tuple(warnings)
