"""The first drape: from a flat pattern to a garment that hangs on a body in any pose."""

from .carry import PosePath, PosingSettings, move_with_skin, pose_cloth
from .dress import DressSettings, dress, place_panels
from .easing import needs_easing
from .follow import DistanceConstraints, PbdSettings, PbdState, build_distance_constraints, simulate_pbd
from .layer_contact import LayerContact
from .motion import MotionSettings, describe_motion, drape_as_scanned
from .sizing import measure_wearer, oversize_measures, size_template
from .stage import DrapeSettings, drape_graded, drape_template, has_hanging_sleeves, redrape, remesh, waist_height
from .tie import pin_waist, tie_contour
from .waist import flat_length, waist_loop
from .wearer import WearerGeometry

__all__ = [
    "DistanceConstraints",
    "DrapeSettings",
    "DressSettings",
    "LayerContact",
    "MotionSettings",
    "PbdSettings",
    "PbdState",
    "PosePath",
    "PosingSettings",
    "WearerGeometry",
    "build_distance_constraints",
    "describe_motion",
    "drape_as_scanned",
    "drape_graded",
    "drape_template",
    "dress",
    "flat_length",
    "has_hanging_sleeves",
    "measure_wearer",
    "move_with_skin",
    "needs_easing",
    "oversize_measures",
    "pin_waist",
    "place_panels",
    "pose_cloth",
    "redrape",
    "remesh",
    "simulate_pbd",
    "size_template",
    "tie_contour",
    "waist_height",
    "waist_loop",
]
