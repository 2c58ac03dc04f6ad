"""A recovered garment worn again: on another body, made to measure, with what it needs of a stored result."""

from .bodies import BodyFile, describe_body_file, find_wearer, read_body_file
from .dressing import STAGES, Dressed, dress_body, is_sound, measure_worn
from .ease import Ease, cut_cloth, measure_ease
from .load import measure_pressure, measure_strain
from .outfit import DressedOutfit, dress_outfit
from .over import dress_over, lay_each, rest_together
from .refit import Refitted, make_to_measure, refit_pattern
from .verdicts import judge_wear
from .waist import carry_curve, match_models
from .worn import WORN, ResultOld, Worn, hang_from, load_worn, save_worn, wear_template, worn_of

__all__ = [
    "STAGES",
    "WORN",
    "BodyFile",
    "Dressed",
    "DressedOutfit",
    "Ease",
    "Refitted",
    "ResultOld",
    "Worn",
    "carry_curve",
    "cut_cloth",
    "describe_body_file",
    "dress_body",
    "dress_outfit",
    "dress_over",
    "find_wearer",
    "hang_from",
    "is_sound",
    "judge_wear",
    "lay_each",
    "load_worn",
    "make_to_measure",
    "match_models",
    "measure_ease",
    "measure_pressure",
    "measure_strain",
    "measure_worn",
    "read_body_file",
    "refit_pattern",
    "rest_together",
    "save_worn",
    "wear_template",
    "worn_of",
]
