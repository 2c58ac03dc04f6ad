"""Losses of the inverse fit: on positions, on control points and on the fabric, each with its gradient."""

from .chamfer import ChamferLoss
from .contours import ContourLoss
from .panels import PanelLoss
from .plane import PlaneLoss
from .range import RangeLoss
from .registered import RegisteredLoss
from .seams import SeamLoss

__all__ = ["ChamferLoss", "ContourLoss", "PanelLoss", "PlaneLoss", "RangeLoss", "RegisteredLoss", "SeamLoss"]
