"""The inverse fit: the pattern from a registered garment, by its metric and through the simulator."""

from ..grade import IsometrySettings, move_pattern
from .body_offset import estimate_body_offset, is_body_estimated
from .bust_darts import add_bust_darts
from .choose_start import choose_start
from .descent import Descent, DescentProblem, InverseSettings, descend
from .fairness import fair_garment
from .hybrid import fit_pattern
from .independence import count_independent
from .inverse import fit_inverse
from .isometry import fit_isometry
from .locks import LockUnknown, find_locked_coordinates, fit_reference, locks_of, restore_locked
from .losses import ChamferLoss, ContourLoss, PanelLoss, PlaneLoss, RangeLoss, RegisteredLoss, SeamLoss
from .material import fit_bending, measure_folding, nearest_fabrics, posterior, ratio_prior
from .rim_corners import prove_corners
from .scene import FitScene
from .settings import MaterialSettings, ShapeSettings
from .shape import ShapeFit, ShapeProblem, fit_shape, seam_null_space

__all__ = [
    "ChamferLoss",
    "ContourLoss",
    "Descent",
    "DescentProblem",
    "FitScene",
    "InverseSettings",
    "IsometrySettings",
    "LockUnknown",
    "MaterialSettings",
    "PanelLoss",
    "PlaneLoss",
    "RangeLoss",
    "RegisteredLoss",
    "SeamLoss",
    "ShapeFit",
    "ShapeProblem",
    "ShapeSettings",
    "add_bust_darts",
    "choose_start",
    "count_independent",
    "descend",
    "estimate_body_offset",
    "fair_garment",
    "find_locked_coordinates",
    "fit_bending",
    "fit_inverse",
    "fit_isometry",
    "fit_pattern",
    "fit_reference",
    "fit_shape",
    "is_body_estimated",
    "locks_of",
    "measure_folding",
    "move_pattern",
    "nearest_fabrics",
    "posterior",
    "prove_corners",
    "ratio_prior",
    "restore_locked",
    "seam_null_space",
]
