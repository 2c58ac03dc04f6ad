"""A recovered garment worn again: on another body, made to measure, with what it needs of a stored result."""

from .bodies import BodyFile, describe_body_file, find_wearer, read_body_file
from .dressing import STAGES, Dressed, dress_body, is_sound, measure_worn
from .verdicts import judge_wear
from .waist import carry_curve, match_models
from .worn import WORN, ResultOld, Worn, hang_from, load_worn, save_worn, worn_of

__all__ = [
    "STAGES",
    "WORN",
    "BodyFile",
    "Dressed",
    "ResultOld",
    "Worn",
    "carry_curve",
    "describe_body_file",
    "dress_body",
    "find_wearer",
    "hang_from",
    "is_sound",
    "judge_wear",
    "load_worn",
    "match_models",
    "measure_worn",
    "read_body_file",
    "save_worn",
    "worn_of",
]
