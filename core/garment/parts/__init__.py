"""Base patterns from parts: a garment's cut as one choice for each part, and the drafts of the parts."""

from .cut import (
    PARTS,
    Bodice,
    Collar,
    Cuff,
    Cut,
    Gores,
    Legs,
    Neckline,
    PartsConflict,
    PartUnknown,
    Shaping,
    Skirt,
    Sleeve,
    SleeveHead,
    SleevePieces,
    Waist,
    Waistband,
    Yoke,
    differing_parts,
    parse_parts,
)
from .draft import draft_cut, half_neck_width
from .necklines import NecklineCut, corner_turn, neckline_points
from .shipped_cuts import CUTS
from .sleeves import SLEEVES

__all__ = [
    "CUTS",
    "PARTS",
    "SLEEVES",
    "Bodice",
    "Collar",
    "Cuff",
    "Cut",
    "Gores",
    "Legs",
    "Neckline",
    "NecklineCut",
    "PartUnknown",
    "PartsConflict",
    "Shaping",
    "Skirt",
    "Sleeve",
    "SleeveHead",
    "SleevePieces",
    "Waist",
    "Waistband",
    "Yoke",
    "corner_turn",
    "differing_parts",
    "draft_cut",
    "half_neck_width",
    "neckline_points",
    "parse_parts",
]
