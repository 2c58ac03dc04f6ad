"""A dressed person's raw scan taken apart: the wearer, and the parts of what is seen."""

from .part import CLOTH, GARMENTS, PARTS, Part

__all__ = ["CLOTH", "GARMENTS", "PARTS", "Part"]
