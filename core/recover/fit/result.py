"""What every method of recovery ends at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...cloth import Fabric, FabricEstimate
from ...garment import Garment, Pattern
from ...garment.meshes import Meshes

if TYPE_CHECKING:
    from ...cloth import Drape
    from ..drape import WearerGeometry
    from ..grade import PanelChange
    from .rim_corners import ProvedCorner


@dataclass(frozen=True)
class Fit:
    """A recovered garment.

    Attributes:
        garment: The recovered pattern, meshed; nodes are the detail mesh's, contours named.
        fabric: The cloth: its bending, or all of it, fitted, or the given one.
        meshes: Graded drape and detail mesh; simulation mesh where the pattern was fitted through the simulator.
        estimates: What is known of each parameter of the fabric; empty where none was fitted.
        nearest: Fabrics of the library that bend most alike, by name; empty where no fabric was fitted.
        point_std: Posterior standard deviation of the control points [m], shape [point_count, 2], or None.
        wearer: The wearer with the body raised to where the cloth rests on it, if it was; None means the case's.
        simulated: The equilibrium behind `meshes.simulation`, or None.
        redrape: The equilibrium behind `meshes.redraped`, or None.
        warnings: What the user should know, one sentence each.
        base: The base pattern with the panels and darts of the recovered one, or None where they are the case's.
        changes: Darts that were added or closed.
        corners: Corners that the scan proves where the base pattern is smooth.
    """

    garment: Garment
    fabric: Fabric
    meshes: Meshes
    estimates: tuple[FabricEstimate, ...] = ()
    nearest: tuple[str, ...] = ()
    point_std: np.ndarray | None = None
    wearer: WearerGeometry | None = None
    simulated: Drape | None = None
    redrape: Drape | None = None
    warnings: tuple[str, ...] = ()
    base: Pattern | None = None
    changes: tuple[PanelChange, ...] = ()
    corners: tuple[ProvedCorner, ...] = ()
