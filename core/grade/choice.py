"""Choose the base pattern for a target."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..errors import BadInput
from ..pattern import Pattern, edge_length, list_templates, load_template
from ..segment import Target

STAND_IN = {"long_sleeve_tshirt": "tshirt", "shorts": "trousers"}
"""The category whose templates serve where there is none of a target's own: sleeves and legs are graded longer or
shorter, but no seam is added."""


class TemplateMissing(BadInput):
    """No template fits this garment; name one with --template NAME or give a pattern file."""

    code = "template.none_fits"


def choose_template(target: Target, names: Sequence[str]) -> str:
    """Name the template that a target is graded from.

    The templates of the target's category compete. First the one whose open contours have the target's names: no
    grading makes a cuff out of an armhole. Among those, the one whose contours are in shape nearest to the target's
    (`contour_misfit`): the least has to be graded then. The first in the library's order wins a tie.

    Args:
        target: The target; its category was chosen from its contours and the bones they encircle.
        names: The templates there are.

    Raises:
        TemplateMissing: where there is none for the category.
    """
    infos = [info for info in list_templates() if info.name in names]
    fitting = [info.name for info in infos if info.category == target.category]
    fitting = fitting or [info.name for info in infos if info.category == STAND_IN.get(target.category)]
    if not fitting:
        raise TemplateMissing(
            f"no template fits the category '{target.category}'; name one of {', '.join(names)} with --template."
        )
    if len(fitting) == 1:
        return fitting[0]
    lengths = {contour.name: contour.length for contour in target.contours if contour.trusted}
    wanted = {contour.name for contour in target.contours}
    measured = [flat_contours(load_template(name)) for name in fitting]
    costs = [(len(wanted ^ set(flat)), contour_misfit(lengths, flat)) for flat in measured]
    return fitting[costs.index(min(costs))]


def flat_contours(pattern: Pattern) -> dict[str, float]:
    """Measure the flat length of every named open contour [m]."""
    lengths: dict[str, float] = {}
    for panel in pattern.panels:
        for i, edge in enumerate(panel.edges):
            if edge.contour:
                lengths[edge.contour] = lengths.get(edge.contour, 0.0) + edge_length(panel, i)
    return lengths


def contour_misfit(target: dict[str, float], template: dict[str, float]) -> float:
    """Tell how unlike in shape two garments' contours are: the variance of ln(target length / template length).

    A common factor is size, which any template takes on, and does not count; what is left is flare and taper. Only
    contours that both have are compared.
    """
    shared = sorted(set(target) & set(template))
    ratios = [math.log(target[name] / template[name]) for name in shared]
    if len(ratios) < 2:
        return 0.0
    mean = sum(ratios) / len(ratios)
    return sum((ratio - mean) ** 2 for ratio in ratios) / len(ratios)
