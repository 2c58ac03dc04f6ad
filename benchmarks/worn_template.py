"""A shipped template at rest on the body that it was drafted for, and whether a drape can be used."""

from __future__ import annotations

import numpy as np
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.drape.shipped import TEMPLATE_WEARER
from garmentq.core.reuse.wear.worn import WornGarment


def load_worn_template(name: str, fabric: Fabric) -> WornGarment | None:
    """Return a shipped template on the built-in female body; None where no drape of it is shipped.

    Args:
        name: Of the template.
        fabric: The cloth.

    Raises:
        TemplateUnknown: where there is no template of that name.
    """
    garment = load_draped_template(name)
    if garment is None:
        return None
    waist = garment.contour("waist")
    curve = None if waist is None else garment.nodes[waist.vertices]
    return WornGarment(
        garment, fabric, builtin_body(TEMPLATE_WEARER), curve, None, name, garment.pattern.category or name
    )


def is_valid_drape(metrics: dict[str, float | None]) -> bool:
    """Check that a garment is at rest, does not cross itself, and is at most 1 mm inside the body."""
    values = [metrics[name] for name in ("body_penetration_mm", "self_intersecting_faces", "drape.at_rest")]
    return bool(np.all([values[0] <= 1.0, values[1] == 0.0, values[2] == 1.0]))  # type: ignore[operator]
