"""Fit a template's draft to a body: widen it by a prediction, drape it, and widen it by the remaining difference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...body.body import Body
from ...body.builtin import builtin_body
from ...body.skinning import rest_body
from ...cloth.fabrics import get_fabric
from ...garment.garment import Garment
from ...garment.measure_change import move_by_drafts
from ...garment.pattern import Pattern
from ...garment.sewing import mesh_pattern
from ...garment.templates import DRAPED_VERTICES, draft_template, load_draped_template
from ...recover.drape.shipped import TEMPLATE_FABRIC, TEMPLATE_WEARER
from ...recover.drape.sizing import measure_wearer
from ...recover.drape.wearer import WearerGeometry
from ...recover.drape.worn_contours import name_worn_contours
from ...run.hooks import SILENT_HOOKS, Hooks
from .dressing import drape_worn, transfer_to_body
from .kept_ease import EasePrediction, max_ease_change, preserve_ease
from .widening import widening_rules
from .worn import WornGarment

EASE_FIT_TOLERANCE = 2e-3
"""Difference of the ease on a drape that is not corrected [m]: the repeatability of a drape on the same body."""

MAX_FITTING_ITERATIONS = 3
"""Largest number of drapes of a draft; bodies for whose thighs the draft is 0.1 m too small need three."""


@dataclass(frozen=True)
class FittedDraft:
    """Describe a template's draft that has the same ease on a body as on the body of the library.

    Attributes:
        pattern: The pattern.
        garment: The garment on the body's T-pose; None where it was not draped.
        body: The body in its T-pose.
        waist: The curve from which it hangs there [m], shape [n, 3], or None.
    """

    pattern: Pattern
    garment: Garment | None
    body: Body
    waist: np.ndarray | None

    def predict_ease(self, other: FittedDraft) -> Mapping[str, float]:
        """Return the predicted ease of another fitting in excess of that on this body [m], by place. Both have the same
        ease, so this is the error of the prediction (`EasePrediction`) from one body to the other."""
        if self.garment is None or other.garment is None:
            return {}
        return EasePrediction.of(self.garment, self.body, self.waist, other.body).predict_change(other.pattern)


def fit_draft(template: str, body: Body, hooks: Hooks = SILENT_HOOKS) -> FittedDraft:
    """Fit a template's draft to a body.

    A draft does not include every girth: the sleeves', the thighs', that where a waistband sits. It is widened until
    its predicted ease is that on the body of the library. The prediction does not include how cloth hangs: wide forks
    lower the crotch, a deep chest draws the sleeves in. So the draft is draped, and widened by the remaining
    difference. The result depends on body and template only, not on the pattern in question.

    Args:
        template: Name of a template.
        body: In any pose.
        hooks: Progress and cancellation.

    Raises:
        TemplateUnknown: where there is no template of that name.
        Cancelled: where the hooks cancel.
    """
    found, shipped = widen_draft(template, body), load_draped_template(template)
    if shipped is None or found.garment is not None:
        return found
    pattern, rest, rules = found.pattern, found.body, widening_rules(template)
    wearer, waist = builtin_body(TEMPLATE_WEARER), _waist_curve(shipped)
    target_ease = EasePrediction.of(shipped, wearer, waist, rest).ease
    geometry = WearerGeometry(rest)
    for _ in range(MAX_FITTING_ITERATIONS):
        mesh = mesh_pattern(pattern, DRAPED_VERTICES)
        worn = WornGarment(
            mesh, get_fabric(TEMPLATE_FABRIC), wearer, waist, None, template, pattern.category or template
        )
        draped, _ = drape_worn(transfer_to_body(worn, rest, None), geometry, hooks)
        contours = name_worn_contours(draped.garment, draped.garment.nodes, rest)
        draped_ease = EasePrediction.of(draped.garment.at(draped.garment.nodes, contours), rest, draped.waist, rest)
        draped_ease = replace(draped_ease, ease=target_ease)
        if max_ease_change(draped_ease, pattern) <= EASE_FIT_TOLERANCE:
            break
        pattern = preserve_ease(pattern, draped_ease, rules)
    return FittedDraft(pattern, draped_ease.place(pattern), rest, draped.waist)


def widen_draft(template: str, body: Body) -> FittedDraft:
    """Return a template's draft for a body, widened until its predicted ease is that on the body of the library.

    Raises:
        TemplateUnknown: where there is no template of that name.
    """
    measures, rest = measure_wearer(body), rest_body(body)
    drafted, shipped = draft_template(template, measures), load_draped_template(template)
    if shipped is None:
        return FittedDraft(drafted, None, rest, None)
    wearer, waist = builtin_body(TEMPLATE_WEARER), _waist_curve(shipped)
    if measures == measure_wearer(wearer):
        return FittedDraft(shipped.pattern, shipped, wearer, waist)
    # with the curves that a refit leaves to the pattern: a draft has its own
    drafted = move_by_drafts(shipped.pattern, shipped.pattern, drafted) or drafted
    laid = EasePrediction.of(shipped, wearer, waist, rest)
    return FittedDraft(preserve_ease(drafted, laid, widening_rules(template)), None, rest, None)


def _waist_curve(garment: Garment) -> np.ndarray | None:
    """Return the curve from which a shipped garment hangs [m], shape [n, 3], or None."""
    contour = garment.contour("waist")
    return None if contour is None else garment.nodes[contour.vertices]
