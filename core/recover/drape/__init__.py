"""The first drape: from a flat pattern to a garment that hangs on a body in any pose."""

from .carry import CarrySettings, Way, carry, take_pose
from .dress import DressSettings, dress, place
from .easing import needs_easing
from .follow import FollowSettings, PbdState, Threads, follow, lay_threads
from .layer_contact import LayerContact
from .motion import MotionSettings, describe_motion, drape_as_scanned
from .sizing import measure_wearer, outgrown_measures, size_template
from .stage import DrapeSettings, drape_graded, drape_template, hangs_in_sleeves, redrape, remesh, waist_height
from .tie import pin_waist, tie_contour
from .waist import flat_length, waist_loop
from .wearer import WearerGeometry

__all__ = [
    "CarrySettings",
    "DrapeSettings",
    "DressSettings",
    "FollowSettings",
    "LayerContact",
    "MotionSettings",
    "PbdState",
    "Threads",
    "Way",
    "WearerGeometry",
    "carry",
    "describe_motion",
    "drape_as_scanned",
    "drape_graded",
    "drape_template",
    "dress",
    "flat_length",
    "follow",
    "hangs_in_sleeves",
    "lay_threads",
    "measure_wearer",
    "needs_easing",
    "outgrown_measures",
    "pin_waist",
    "place",
    "redrape",
    "remesh",
    "size_template",
    "take_pose",
    "tie_contour",
    "waist_height",
    "waist_loop",
]
