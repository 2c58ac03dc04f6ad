"""One garment on its way from the base pattern to the result: the value that every step of a recovery improves."""

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
    """Describe what is recovered of a garment so far.

    Attributes:
        template: Name of the base pattern.
        base: The base pattern, with the panels and darts of the garment's: gives symmetry, proportions, gathered seams.
        target: What the garment has to reach: the seen surface, completed where another garment hides it.
        wearer: The body, raised to where the cloth rests on it once a step has found out.
        fabric: The cloth, as it is known by now.
        garment: The mesh of the pattern as it is by now, nodes where the last step left them; None before it is worn.
        graded: The graded pattern's mesh, nodes at its drape; None before that.
        drape: The equilibrium behind it.
        laid: Its nodes on the target, where the sliding of a pattern with free curves left them [m], shape
            [node_count, 3]; None for others, and where hanging arms hide so much cloth that layers of it would lie in
            each other.
        meshes: Nodes of the meshes that are delivered; None before the garment was registered.
        simulated: The equilibrium behind `meshes.simulation`, or None.
        redrape: The equilibrium behind `meshes.redraped`, or None.
        estimates: What is known of each parameter of the fabric; empty where none was fitted.
        nearest: Fabrics of the library that bend most alike, by name; empty likewise.
        point_std: Posterior standard deviation of the control points [m], shape [point_count, 2], or None.
        corners: Corners that the scan proves where the base pattern is smooth.
        findings: What the steps found, in their order.
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
        """Return the pattern as it is by now: the base pattern's before it was graded."""
        return self.base if self.garment is None else self.garment.pattern

    def with_findings(self, *findings: Finding) -> RecoveryState:
        """Return the state with more that was found."""
        return replace(self, findings=(*self.findings, *findings))

    def with_notes(self, *messages: str) -> RecoveryState:
        """Return the state with more that the user should know."""
        return self.with_findings(*map(note, messages))


def made(value: T | None) -> T:
    """Return what an earlier step has made.

    Raises:
        LookupError: where it has not: the steps of a method stand in a wrong order.
    """
    if value is None:
        raise LookupError("a step runs before the one that makes what it starts from")
    return value
