"""The wearer: a mesh with joints, bones, skinning weights and a signed distance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..run.lazy import import_lazily
from .body import JOINT_PARENTS, JOINTS, Body
from .spec import BUILTIN, BuiltinWearer, Wearer, is_builtin, read_wearer

if TYPE_CHECKING:
    from .builtin import POSES, BodyMissing, BodySpecBad, builtin_body, describe_bodies, parse_spec
    from .current import advect_outside
    from .distance import DistanceBad, DistanceGrid, sample_distance
    from .exposed import ExposedSurface, penetration_depth, pinched_depth
    from .girths import BELOW_ARMPIT, GIRTHS, Girth, TapeMeasure, armpit_height, crotch_height
    from .hanging_arms import find_hanging_arms, lies_under_arm
    from .measured import MeasureRange
    from .measures_file import MeasuresBad, read_measures
    from .model import BodyModel
    from .person import PersonFit, PersonSettings, PointWeights, fit_person, refit_person
    from .posing import check_wearer, pose_body
    from .projection import exit_displacements, project_outside
    from .registration import NotHuman, register_body
    from .resizing import resize_body
    from .signed_distance import SignedDistance
    from .skinning import rest_body, skin, unskin, weights_at
    from .smpl import SmplBad, is_smpl, load_smpl
    from .solid import Solid
    from .untangling import untangle_outside

_LAZY = {
    "MeasuresBad": "measures_file",
    "read_measures": "measures_file",
    "BELOW_ARMPIT": "girths",
    "GIRTHS": "girths",
    "Girth": "girths",
    "TapeMeasure": "girths",
    "armpit_height": "girths",
    "crotch_height": "girths",
    "MeasureRange": "measured",
    "POSES": "builtin",
    "BodyMissing": "builtin",
    "BodyModel": "model",
    "BodySpecBad": "builtin",
    "ExposedSurface": "exposed",
    "DistanceBad": "distance",
    "DistanceGrid": "distance",
    "NotHuman": "registration",
    "PersonFit": "person",
    "PersonSettings": "person",
    "PointWeights": "person",
    "SignedDistance": "signed_distance",
    "SmplBad": "smpl",
    "Solid": "solid",
    "builtin_body": "builtin",
    "advect_outside": "current",
    "check_wearer": "posing",
    "describe_bodies": "builtin",
    "find_hanging_arms": "hanging_arms",
    "fit_person": "person",
    "is_smpl": "smpl",
    "lies_under_arm": "hanging_arms",
    "load_smpl": "smpl",
    "parse_spec": "builtin",
    "penetration_depth": "exposed",
    "pinched_depth": "exposed",
    "pose_body": "posing",
    "project_outside": "projection",
    "refit_person": "person",
    "register_body": "registration",
    "resize_body": "resizing",
    "rest_body": "skinning",
    "sample_distance": "distance",
    "skin": "skinning",
    "unskin": "skinning",
    "untangle_outside": "untangling",
    "exit_displacements": "projection",
    "weights_at": "skinning",
}
# Modules with compiled kernels or heavy libraries: imported on first use, so that the room itself stays light.

__all__ = [
    "BELOW_ARMPIT",
    "BUILTIN",
    "GIRTHS",
    "JOINTS",
    "JOINT_PARENTS",
    "POSES",
    "Body",
    "BodyMissing",
    "BodyModel",
    "BodySpecBad",
    "BuiltinWearer",
    "DistanceBad",
    "DistanceGrid",
    "ExposedSurface",
    "Girth",
    "MeasureRange",
    "MeasuresBad",
    "NotHuman",
    "PersonFit",
    "PersonSettings",
    "PointWeights",
    "SignedDistance",
    "SmplBad",
    "Solid",
    "TapeMeasure",
    "Wearer",
    "advect_outside",
    "armpit_height",
    "builtin_body",
    "check_wearer",
    "crotch_height",
    "describe_bodies",
    "exit_displacements",
    "find_hanging_arms",
    "fit_person",
    "is_builtin",
    "is_smpl",
    "lies_under_arm",
    "load_smpl",
    "parse_spec",
    "penetration_depth",
    "pinched_depth",
    "pose_body",
    "project_outside",
    "read_measures",
    "read_wearer",
    "refit_person",
    "register_body",
    "resize_body",
    "rest_body",
    "sample_distance",
    "skin",
    "unskin",
    "untangle_outside",
    "weights_at",
]

__getattr__ = import_lazily(__name__, _LAZY)
