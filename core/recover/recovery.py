"""Define the request and the result of one recovery."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ..body.spec import Wearer
from ..scan.selection import Selection
from .settings import RecoverySettings

if TYPE_CHECKING:  # so that a bad file is refused without importing the other packages
    import numpy as np

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
"""The stages of a recovery in order, the names by which progress and seconds are reported. Only methods that recover
the pattern through the simulator have `fit` and `redrape`."""


@dataclass(frozen=True)
class Request:
    """Describe the files of one recovery.

    Attributes:
        scan: The garment's file; or the dressed person's, where labels or the settings select the garment.
        body: The wearer's mesh file, a built-in body, or None if the scan has it (a garment alone: `body.missing`).
        template: A pattern file that serves as the base pattern, or None to choose from the library.
        settings: Everything else.
        labels: A file with one label per vertex of a dressed person's scan, or None.
        reading: The files' contents, where a limited process has read them already; None: they are read here.
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
    """Describe which part of a scan is the garment, by label file and settings; None where neither selects one."""
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
    """Describe the result of a recovery.

    Attributes:
        scan: The checked scan.
        body: The wearer.
        target: The garment's surface with its contours.
        template: Name of the template that was used.
        pattern: The recovered pattern: graded, and with the method `hybrid` fitted.
        fabric: The fabric.
        garment: The recovered pattern meshed and sewn; its nodes are the detail mesh.
        meshes: Node positions of graded drape, detail, simulation and re-draped mesh.
        report: Metrics, verdicts, warnings, cost and manifest.
        estimates: Estimate of each fabric parameter; empty where the method fits none.
        nearest_fabrics: Names of the library's fabrics with the most similar bending; empty where none is fitted.
        point_std: Posterior standard deviation of the control points [m], shape [point_count, 2], or None.
        rotation: The rotation of cloth and wearer that was found, or None for cloth at rest.
        pieces: Numbers of each production piece; empty where none can be cut.
        seen: Whether the scan shows each face of the detail mesh, bool, shape [face_count]; the others are inferred.
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
    seen: np.ndarray | None = None

    @property
    def inferred_nodes(self) -> np.ndarray:
        """Return the nodes that no face which the scan shows has, bool, shape [node_count]."""
        import numpy as np

        from ..judge.seen import find_seen_nodes

        seen = np.ones(len(self.garment.faces), dtype=bool) if self.seen is None else self.seen
        return ~find_seen_nodes(self.garment, seen)
