"""A shipped template drafted to a body's own measures, whatever its size."""

from __future__ import annotations

from garmentq.core.body.body import Body
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.templates import draft_template
from garmentq.core.recover.drape.sizing import measure_wearer


def size_template(name: str, body: Body) -> Pattern:
    """Draft a shipped template from the measures of a body.

    Raises:
        TemplateUnknown: where no template has that name.
    """
    return draft_template(name, measure_wearer(body))
