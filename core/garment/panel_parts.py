"""Find the part of a garment that a panel belongs to, by the words of its label or name."""

from __future__ import annotations

from .pattern import Panel

PART_WORDS = ("sleeve", "arm", "cuff", "collar", "hood", "band", "wb", "skirt", "leg", "pant", "yoke", "body", "torso")
"""Words of labels, or else of names, of panels that say which part of a garment they belong to."""


def find_part(panel: Panel) -> str:
    """Return the part of a garment that a panel belongs to, one of `PART_WORDS`; an empty text where neither label nor
    name says it."""
    for text in (panel.label.lower(), panel.name.lower()):
        for word in PART_WORDS:
            if word in text:
                return word
    return ""
