"""The first drape: from a flat pattern to a garment that hangs on a body in any pose."""

from .carry import CarrySettings, carry
from .dress import DressSettings, dress, place, waist_loop
from .follow import FollowSettings, Threads, follow, lay_threads
from .stage import DrapeSettings, Stand, drape_graded, drape_template, redrape, waist_height
from .tie import tie_contour

__all__ = [
    "CarrySettings",
    "DrapeSettings",
    "DressSettings",
    "FollowSettings",
    "Stand",
    "Threads",
    "carry",
    "drape_graded",
    "drape_template",
    "dress",
    "follow",
    "lay_threads",
    "place",
    "redrape",
    "tie_contour",
    "waist_height",
    "waist_loop",
]
