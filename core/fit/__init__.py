"""The inverse fit: the pattern from a registered garment, by its metric and through the simulator."""

from .hybrid import PatternFit, fit_pattern
from .losses import RegisteredLoss
from .metric import move_pattern, refit_pattern
from .settings import ShapeSettings
from .shape import ShapeFit, ShapeProblem, fit_shape, keep_seams

__all__ = [
    "PatternFit",
    "RegisteredLoss",
    "ShapeFit",
    "ShapeProblem",
    "ShapeSettings",
    "fit_pattern",
    "fit_shape",
    "keep_seams",
    "move_pattern",
    "refit_pattern",
]
