"""Define the recovery state, the value that every step of a recovery improves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from ..body.body import Body
from ..cloth.fabric import Fabric, FabricEstimate
from ..cloth.statics import Drape
from ..garment.garment import Garment
from ..garment.meshes import Meshes
from ..garment.pattern import Pattern
from ..run.finding import Finding, note
from ..scan.contours.target import Target
from .drape.wearer import WearerGeometry
from .proved_corner import ProvedCorner

T = TypeVar("T")


@dataclass(frozen=True)
class RecoveryState:
    """Describe what has been recovered of a garment so far.

    Attributes:
        template: Name of the base pattern.
        base: The base pattern with the garment's present panels and darts; gives symmetry, proportions, gathered seams.
        target: The surface to reach: the seen surface, completed where another garment hides it.
        wearer: The body; raised to where the cloth rests on it once a step has estimated the offset.
        fabric: The present estimate of the cloth.
        garment: The mesh of the present pattern, nodes as the last step left them; None before dressing.
        graded: The graded pattern's mesh, nodes at its drape; None before that.
        drape: The equilibrium of `graded`.
        laid: The garment's nodes [m], shape [node_count, 3], on the target, from the sliding of a pattern with free
            curves. None for other patterns, and where hanging arms hide so much cloth that its layers would cross.
        meshes: Nodes of the delivered meshes; None before registration.
        simulated: The equilibrium of `meshes.simulation`, or None.
        redrape: The equilibrium of `meshes.redraped`, or None.
        estimates: Estimate of each fabric parameter; empty where none was fitted.
        nearest: Names of the library's fabrics with the most similar bending; empty where none was fitted.
        point_std: Posterior standard deviation of the control points [m], shape [point_count, 2], or None.
        corners: Corners that the scan proves where the base pattern is smooth.
        findings: What the steps found, in order.
    """

    template: str
    base: Pattern
    target: Target
    wearer: WearerGeometry
    fabric: Fabric
    garment: Garment | None = None
    graded: Garment | None = None
    drape: Drape | None = None
    laid: np.ndarray | None = None
    meshes: Meshes | None = None
    simulated: Drape | None = None
    redrape: Drape | None = None
    estimates: tuple[FabricEstimate, ...] = ()
    nearest: tuple[str, ...] = ()
    point_std: np.ndarray | None = None
    corners: tuple[ProvedCorner, ...] = ()
    findings: tuple[Finding, ...] = ()

    @property
    def body(self) -> Body:
        """Return the wearer's body."""
        return self.wearer.body

    @property
    def pattern(self) -> Pattern:
        """Return the present pattern: the base pattern before dressing."""
        return self.base if self.garment is None else self.garment.pattern

    def with_findings(self, *findings: Finding) -> RecoveryState:
        """Return the state with further findings."""
        return replace(self, findings=(*self.findings, *findings))

    def with_notes(self, *messages: str) -> RecoveryState:
        """Return the state with further notes to the user."""
        return self.with_findings(*map(note, messages))


def made(value: T | None) -> T:
    """Return a value that an earlier step has set.

    Raises:
        LookupError: where it is None: the method lists its steps in a wrong order.
    """
    if value is None:
        raise LookupError("a step runs before the one that makes what it starts from")
    return value
