"""A result's pattern edited: draped from where its garment hangs, judged, and compared with what it was."""

from .compare import PatternDifference, SeamChange, compare_versions
from .redraping import STAGES, EditedGarment, drape_edit, worn_length

__all__ = [
    "STAGES",
    "EditedGarment",
    "PatternDifference",
    "SeamChange",
    "compare_versions",
    "drape_edit",
    "worn_length",
]
