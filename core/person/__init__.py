"""A dressed person's raw scan taken apart: the wearer, and the parts of what is seen."""

from .part import CLOTH, GARMENTS, Part

__all__ = ["CLOTH", "GARMENTS", "Part"]
