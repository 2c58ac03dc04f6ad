"""A recovered garment worn again: on another body, made to measure, with what it needs of a stored result."""

from .bodies import BodyFile, describe_body_file, find_wearer, read_body_file
from .dressing import STAGES, DressedGarment, dress_body, is_valid_drape, measure_worn
from .ease import Ease, measure_ease, slice_cloth
from .load import measure_pressure, measure_strain
from .outfit import DressedOutfit, dress_outfit
from .over import drape_in_order, drape_together, dress_over
from .refit import RefittedPattern, make_to_measure, refit_pattern
from .verdicts import judge_wear
from .waist import match_models, transfer_curve
from .worn import (
    WORN_FILE_NAME,
    ResultOld,
    WornGarment,
    load_worn,
    load_worn_template,
    make_waist_target,
    save_worn,
    worn_from_recovery,
)

__all__ = [
    "STAGES",
    "WORN_FILE_NAME",
    "BodyFile",
    "DressedGarment",
    "DressedOutfit",
    "Ease",
    "RefittedPattern",
    "ResultOld",
    "WornGarment",
    "describe_body_file",
    "drape_in_order",
    "drape_together",
    "dress_body",
    "dress_outfit",
    "dress_over",
    "find_wearer",
    "is_valid_drape",
    "judge_wear",
    "load_worn",
    "load_worn_template",
    "make_to_measure",
    "make_waist_target",
    "match_models",
    "measure_ease",
    "measure_pressure",
    "measure_strain",
    "measure_worn",
    "read_body_file",
    "refit_pattern",
    "save_worn",
    "slice_cloth",
    "transfer_curve",
    "worn_from_recovery",
]
