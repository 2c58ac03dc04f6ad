"""From a scan and a body to the garment's surface with its open contours named."""

from .target import CATEGORIES, CONTOUR_NAMES, Contour, Target

__all__ = ["CATEGORIES", "CONTOUR_NAMES", "Contour", "Target"]
