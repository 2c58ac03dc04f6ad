"""Cloth in motion: a garment on a wearer who moves."""

from .animation import STAGE, Animation, Verdict, animate, list_times
from .clearing import Clearing, clear_motion
from .measured import judge_animation, judge_motion, measure_animation
from .moved import Moved, move_worn
from .settings import AnimateBad, AnimateSettings

__all__ = [
    "STAGE", "AnimateBad", "AnimateSettings", "Animation", "Clearing", "Moved", "Verdict", "animate",
    "clear_motion", "judge_animation", "judge_motion", "list_times", "measure_animation", "move_worn",
]  # fmt: skip
