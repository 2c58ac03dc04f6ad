"""The inverse fit: the pattern from a registered garment, by its metric and through the simulator."""

from .hybrid import PatternFit, fit_pattern
from .isometry import IsometrySettings, fit_isometry
from .locks import LockUnknown, find_held, keep_held
from .losses import RegisteredLoss
from .material import fit_bending, folding, nearest_fabrics, posterior, ratio_prior
from .metric import move_pattern
from .settings import MaterialSettings, ShapeSettings
from .shape import ShapeFit, ShapeProblem, fit_shape, keep_seams

__all__ = [
    "IsometrySettings",
    "LockUnknown",
    "MaterialSettings",
    "PatternFit",
    "RegisteredLoss",
    "ShapeFit",
    "ShapeProblem",
    "ShapeSettings",
    "find_held",
    "fit_bending",
    "fit_isometry",
    "fit_pattern",
    "fit_shape",
    "folding",
    "keep_held",
    "keep_seams",
    "move_pattern",
    "nearest_fabrics",
    "posterior",
    "ratio_prior",
]
