"""The inverse fit: the pattern from a registered garment, by its metric and through the simulator."""

from ..grade import IsometrySettings, move_pattern
from .body_offset import estimate_body_offset, is_estimated
from .bust_darts import DartedGarment, add_bust_darts
from .descent import Descent, DescentProblem, InverseSettings, descend
from .fairness import fair_garment
from .hybrid import fit_pattern
from .independence import count_independent
from .inverse import InverseFit, fit_inverse
from .isometry import fit_isometry
from .locks import LockUnknown, find_held, keep_held
from .losses import ChamferLoss, ContourLoss, PanelLoss, PlaneLoss, RangeLoss, RegisteredLoss, SeamLoss
from .material import fit_bending, folding, nearest_fabrics, posterior, ratio_prior
from .methods import METHODS, Graded, Hybrid, Inverse, Method
from .result import Fit
from .scene import FitScene
from .settings import MaterialSettings, ShapeSettings
from .shape import ShapeFit, ShapeProblem, fit_shape, keep_seams
from .uncross import uncross

__all__ = [
    "METHODS",
    "ChamferLoss",
    "ContourLoss",
    "DartedGarment",
    "Descent",
    "DescentProblem",
    "Fit",
    "FitScene",
    "Graded",
    "Hybrid",
    "Inverse",
    "InverseFit",
    "InverseSettings",
    "IsometrySettings",
    "LockUnknown",
    "MaterialSettings",
    "Method",
    "PanelLoss",
    "PlaneLoss",
    "RangeLoss",
    "RegisteredLoss",
    "SeamLoss",
    "ShapeFit",
    "ShapeProblem",
    "ShapeSettings",
    "add_bust_darts",
    "count_independent",
    "descend",
    "estimate_body_offset",
    "fair_garment",
    "find_held",
    "fit_bending",
    "fit_inverse",
    "fit_isometry",
    "fit_pattern",
    "fit_shape",
    "folding",
    "is_estimated",
    "keep_held",
    "keep_seams",
    "move_pattern",
    "nearest_fabrics",
    "posterior",
    "ratio_prior",
    "uncross",
]
