"""From a scan and a body to the garment's surface with its open contours named."""

from .category import choose_category
from .contours import name_contours
from .garment import NoContour, PartMissing, SeveralGarments, segment_garment
from .loop import find_loops, smooth_loop, smooth_ragged_loop, smoothed_length
from .misfit import find_misfit_warnings
from .neck import NeckLines, unroll_neck
from .noise import smooth_noise
from .spikes import flatten_spikes
from .target import CATEGORIES, CONTOUR_NAMES, TOP_CATEGORIES, Contour, Target, mark_hidden_border

__all__ = [
    "CATEGORIES",
    "CONTOUR_NAMES",
    "TOP_CATEGORIES",
    "Contour",
    "NeckLines",
    "NoContour",
    "PartMissing",
    "SeveralGarments",
    "Target",
    "choose_category",
    "find_loops",
    "find_misfit_warnings",
    "flatten_spikes",
    "mark_hidden_border",
    "name_contours",
    "segment_garment",
    "smooth_loop",
    "smooth_noise",
    "smooth_ragged_loop",
    "smoothed_length",
    "unroll_neck",
]
