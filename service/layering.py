"""Order a person's garments by layer, from what was found of their openings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..core.people.part import Part

LAYER_ORDER = (Part.LOWER, Part.ONE_PIECE, Part.UPPER, Part.OUTER)
"""Garments from the innermost to the outermost by default."""


def order_garments(person: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the words of a person's garments that have no problem, from the innermost to the outermost.

    A top hangs over a bottom, unless the bottom covers the top's hem and its own waist is seen: then it is tucked in.
    An outer layer is over all.

    Args:
        person: A result of `describe_person`.
    """
    found = {str(garment["part"]): garment for garment in person["garments"]}
    words = [part.word for part in LAYER_ORDER if part.word in found and not found[part.word].get("problem")]
    upper, lower = Part.UPPER.word, Part.LOWER.word
    if upper in words and lower in words and is_tucked(found[upper], found[lower]):
        words.remove(upper)
        words.insert(words.index(lower), upper)
    return tuple(words)


def is_tucked(upper: Mapping[str, Any], lower: Mapping[str, Any]) -> bool:
    """Check whether a top's hem is hidden and the waist of the bottom is seen."""
    hems = [contour["is_inferred"] for contour in upper["contours"] if contour["name"] == "hem"]
    waists = [contour["is_inferred"] for contour in lower["contours"] if contour["name"] == "waist"]
    return bool((all(hems) or not hems) and waists and not any(waists))
