"""Colours in which a person's parts are shown, in pictures, files and pages."""

from __future__ import annotations

import numpy as np

from .part import Part

COLOURS = {
    Part.SKIN: (0.90, 0.76, 0.66),
    Part.HAIR: (0.30, 0.22, 0.18),
    Part.SHOES: (0.35, 0.33, 0.55),
    Part.UPPER: (0.27, 0.51, 0.76),
    Part.LOWER: (0.89, 0.55, 0.24),
    Part.ONE_PIECE: (0.35, 0.64, 0.44),
    Part.OUTER: (0.72, 0.36, 0.55),
    Part.OTHER: (0.62, 0.62, 0.62),
}
"""A colour for each part: skin and hair near their own, the garments apart without red-green vision."""

UNSURE, SURE = np.array([0.80, 0.25, 0.20]), np.array([0.86, 0.88, 0.88])
"""Colours of a confidence of one half and of one."""
