"""Cloth in motion: a garment on a wearer who moves."""

from .animation import STAGE, Animation, FrameVerdict, animate, list_times
from .clearing import LimbSpread, make_room_for_garment
from .measured import judge_animation, judge_motion, measure_animation
from .moved import AnimatedGarment, animate_garment
from .settings import AnimateBad, AnimateSettings

__all__ = [
    "STAGE",
    "AnimateBad",
    "AnimateSettings",
    "AnimatedGarment",
    "Animation",
    "FrameVerdict",
    "LimbSpread",
    "animate",
    "animate_garment",
    "judge_animation",
    "judge_motion",
    "list_times",
    "make_room_for_garment",
    "measure_animation",
]  # fmt: skip
