"""Grading of a base pattern: contours along the bones, and the stretch between them (thesis 3.2.3)."""

from .bust_points import BustPoints, find_bust_points
from .choice import Candidate, Choice, TemplateMissing, choose_cut, choose_template
from .completion import complete_target
from .cut_name import describe_cut_change, name_recovered
from .distances import ContourMeasure, compare_contours, position_along
from .flattening import (
    FlatteningSettings,
    fit_control_points,
    mean_width,
    narrow_panels,
    seam_rows,
    solve_with_seams,
    stretch_between,
)
from .grading import GradeSettings, Grading, grade_pattern, move_pattern, step_without_folds
from .hem_corners import HemShare, share_by_hems
from .isometry import Isometry, IsometrySettings
from .parts import find_parts
from .proportion import Proportions, area_growth, find_proportions
from .registration import RegistrationSettings, register_coarsely
from .sliding import SlideSettings, can_be_meshed, mesh_coarsely, slide_seams, solve_isometry
from .strain import clamp_stretch, subgrid_stretch
from .trunk_curvature import TrunkCurvature

__all__ = [
    "BustPoints",
    "Candidate",
    "Choice",
    "ContourMeasure",
    "FlatteningSettings",
    "GradeSettings",
    "Grading",
    "HemShare",
    "Isometry",
    "IsometrySettings",
    "Proportions",
    "RegistrationSettings",
    "SlideSettings",
    "TemplateMissing",
    "TrunkCurvature",
    "area_growth",
    "can_be_meshed",
    "choose_cut",
    "choose_template",
    "clamp_stretch",
    "compare_contours",
    "complete_target",
    "describe_cut_change",
    "find_bust_points",
    "find_parts",
    "find_proportions",
    "fit_control_points",
    "grade_pattern",
    "mean_width",
    "mesh_coarsely",
    "move_pattern",
    "name_recovered",
    "narrow_panels",
    "position_along",
    "register_coarsely",
    "seam_rows",
    "share_by_hems",
    "slide_seams",
    "solve_isometry",
    "solve_with_seams",
    "step_without_folds",
    "stretch_between",
    "subgrid_stretch",
]
