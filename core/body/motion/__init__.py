"""Motions of a wearer: read from files, retargeted to the wearer's skeleton, sampled at any time."""

from .clear_limbs import LIMB_GROUPS, MAX_LIMB_SPREAD_ANGLE, ClearedMotion, clear_limbs
from .errors import MotionBad, MotionForeign, MotionTooLarge
from .moving_body import MovingBody
from .read import load_motion
from .recording import Recording
from .retarget import retarget
from .shipped import SHIPPED_MOTIONS, find_shipped_motion
from .track import LeadIn, Pose, Track

__all__ = [
    "LIMB_GROUPS", "MAX_LIMB_SPREAD_ANGLE", "SHIPPED_MOTIONS", "ClearedMotion", "LeadIn", "MotionBad", "MotionForeign",
    "MotionTooLarge", "MovingBody",
    "Pose", "Recording", "Track", "clear_limbs", "find_shipped_motion", "load_motion", "retarget",
]  # fmt: skip
