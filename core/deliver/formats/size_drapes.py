"""Drape the sizes of a garment, each on a body by its measures, to check that they can be worn."""

from __future__ import annotations

from dataclasses import replace

from ...body.resizing import resize_body
from ...garment.sewing import mesh_pattern
from ...reuse.wear.dressing import DressedGarment, dress_body
from ...reuse.wear.worn import WornGarment
from ...run.clock import Clock
from ...run.hooks import SILENT_HOOKS, Hooks
from .grading import Size

SIZE_POSE = "A"
"""Pose of the bodies, as in a fitting."""


def drape_size(worn: WornGarment, size: Size, hooks: Hooks = SILENT_HOOKS) -> DressedGarment:
    """Dress a body by a size's measures in that size; the body has the wearer's figure otherwise.

    Args:
        worn: The garment on its wearer.
        size: One of its sizes.
        hooks: Progress and cancellation.

    Raises:
        MeasureRange: where the built-in model has no body with these measures.
        Cancelled: where the hooks cancel.
    """
    names = {"chest": "bust", "waist": "waist", "hip": "hip"}
    growth = {place: getattr(size.growth, name) for place, name in names.items()}
    body = resize_body(worn.body, growth, size.growth.stature, SIZE_POSE)
    garment = mesh_pattern(size.pattern, len(worn.garment.nodes))
    return dress_body(replace(worn, garment=garment), body, None, Clock(hooks))
