"""What one recovery takes and gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..body.spec import Wearer
from ..scan.selection import Selection
from .settings import RecoverySettings

if TYPE_CHECKING:  # so that a refusal of a bad file need not wait for the other rooms
    from ..body.body import Body
    from ..cloth.fabric import Fabric, FabricEstimate
    from ..cloth.scene import SteadyRotation
    from ..garment.garment import Garment
    from ..garment.meshes import Meshes
    from ..garment.pattern import Pattern
    from ..garment.pieces.numbers import PieceNumbers
    from ..garment.reading import Reading
    from ..run.report import ResultReport
    from ..scan.contours.target import Target
    from ..scan.scan import Scan

STAGES = ("scan", "body", "segment", "template", "grade", "drape", "deform", "fit", "redrape", "measure")
"""The stages of a recovery in order; progress and seconds are reported by these names. Only methods that recover the
pattern through the simulator have `fit` and `redrape`."""


@dataclass(frozen=True)
class Request:
    """Name the files of one recovery.

    Attributes:
        scan: The garment's file; or the dressed person's, where labels or the settings say what of it is the garment.
        body: The wearer's mesh file, a built-in body, or None: then it must be in the scan, and is refused with
            `body.missing` where that is a garment alone.
        template: A pattern file that serves as the base pattern, or None to choose from the library.
        settings: Everything else.
        labels: A file with one label per vertex of a dressed person's scan, or None.
        reading: What the files hold, where a limited process has read them already; None: they are read here.
    """

    scan: Path
    body: Wearer | None = None
    template: Path | None = None
    settings: RecoverySettings = field(default_factory=RecoverySettings)
    labels: Path | None = None
    reading: Reading | None = None

    @property
    def selection(self) -> Selection | None:
        """Describe which part of the scan is the garment; None where it is all of it."""
        return make_selection(self.labels, self.settings)


def make_selection(labels: Path | None, settings: RecoverySettings) -> Selection | None:
    """Describe which part of a scan is the garment by a label file and settings; None where neither says anything."""
    if labels is None and settings.keep is None and settings.keep_colour is None:
        return None
    return Selection(
        labels,
        settings.labels_key,
        settings.kept_labels,
        settings.keep_colour,
        settings.colour_tolerance,
        settings.cloth_labels,
    )


@dataclass(frozen=True)
class Recovery:
    """Describe everything a recovery found.

    Attributes:
        scan: The checked scan.
        body: The wearer.
        target: The garment's surface with its contours.
        template: Name of the template that was used.
        pattern: The recovered pattern: graded, and with the method `hybrid` fitted.
        fabric: The fabric.
        garment: The recovered pattern meshed and sewn; its nodes are the detail mesh.
        meshes: Node positions of graded drape, detail, simulation and re-draped mesh.
        report: Numbers, verdicts, warnings, cost, and what reproduces it.
        estimates: What the fit knows of each parameter of the fabric; empty where the method fits none.
        nearest_fabrics: Fabrics of the library that bend most alike, by name; empty likewise.
        point_std: Posterior standard deviation of the control points [m], shape [point_count, 2], or None.
        rotation: The rotation in which the cloth was found to turn with its wearer, or None for cloth at rest.
        pieces: Of each production piece of the pattern, its numbers; empty where none can be cut.
    """

    scan: Scan
    body: Body
    target: Target
    template: str
    pattern: Pattern
    fabric: Fabric
    garment: Garment
    meshes: Meshes
    report: ResultReport
    estimates: tuple[FabricEstimate, ...] = ()
    nearest_fabrics: tuple[str, ...] = ()
    point_std: np.ndarray | None = None
    rotation: SteadyRotation | None = None
    pieces: tuple[PieceNumbers, ...] = ()
