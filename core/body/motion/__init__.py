"""Motions of a wearer: read from files, retargeted to the wearer's skeleton, sampled at any time."""

from .clear_limbs import GROUPS, LIMIT, Cleared, clear_limbs
from .errors import MotionBad, MotionForeign, MotionTooLarge
from .moving_body import MovingBody
from .read import load_motion
from .recording import Recording
from .retarget import retarget
from .shipped import SHIPPED, find_shipped
from .track import LeadIn, Pose, Track

__all__ = [
    "GROUPS", "LIMIT", "SHIPPED", "Cleared", "LeadIn", "MotionBad", "MotionForeign", "MotionTooLarge", "MovingBody",
    "Pose", "Recording", "Track", "clear_limbs", "find_shipped", "load_motion", "retarget",
]  # fmt: skip
