"""A dressed person's raw scan taken apart: the wearer, and the parts of what is seen."""

from .part import CLOTH, GARMENTS, PARTS, Part
from .separation import FoundContour, FoundGarment, LabelledPerson, Outfit

__all__ = [
    "CLOTH",
    "GARMENTS",
    "PARTS",
    "FoundContour",
    "FoundGarment",
    "LabelledPerson",
    "Outfit",
    "Part",
]
