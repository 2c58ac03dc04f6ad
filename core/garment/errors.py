"""Errors of a pattern, one stable code each."""

from __future__ import annotations

from dataclasses import dataclass

from ..run.errors import BadInput


@dataclass(frozen=True)
class Place:
    """Describe the place of a fault in a pattern: the panel's name, and the numbers of the edge and the control point
    and the point in the panel's own axes, each or None."""

    panel: str
    edge: int | None = None
    vertex: int | None = None
    point: tuple[float, float] | None = None


class PatternFault(BadInput):
    """Something is wrong with a pattern; the places say where.

    Attributes:
        places: Edges and points by the pattern's numbers; for a file by the file's numbers.
        seam: Number of the seam, or None.
    """

    code = "pattern.bad"
    places: tuple[Place, ...] = ()
    seam: int | None = None

    def __init__(self, message: str | None = None, *places: Place, seam: int | None = None) -> None:
        super().__init__(message)
        self.places, self.seam = places, seam


class PatternUnreadable(PatternFault):
    """The pattern file cannot be read; give a GarmentCode or NeuralTailor pattern as JSON."""

    code = "pattern.unreadable"


class PatternTooLarge(PatternFault):
    """The pattern file is larger than a garment needs; see docs/reference/files.md for the caps."""

    code = "pattern.too_large"


class PatternIncomplete(PatternFault):
    """The pattern file lacks a key that the GarmentCode format requires; export it again from its program."""

    code = "pattern.incomplete"


class PatternUnitsMissing(PatternFault):
    """The pattern file does not say its units; add properties.units_in_meter (100 for centimetres)."""

    code = "pattern.units_missing"


class PatternUnitsUnclear(PatternFault):
    """The pattern is too small or too large for a garment in its file's unit; say the unit with --units."""

    code = "pattern.units_unclear"


class PatternValueBad(PatternFault):
    """A value in the pattern file has the wrong type or is out of range."""

    code = "pattern.value_bad"


class PanelOpen(PatternFault):
    """The edges of a panel do not form one closed loop; each vertex must end one edge and start one other."""

    code = "pattern.open_loop"


class PanelCrossing(PatternFault):
    """The outline of a panel crosses itself; redraw it as a simple closed loop."""

    code = "pattern.self_crossing"


class PanelDegenerate(PatternFault):
    """A panel has no area, or an edge no length; remove it from the pattern."""

    code = "pattern.degenerate"


class SeamUnknown(PatternFault):
    """A stitch names a panel or an edge that the pattern does not have."""

    code = "pattern.seam_unknown"


class SeamTwice(PatternFault):
    """An edge takes part in two stitches; split the edge so that each part is sewn once."""

    code = "pattern.edge_sewn_twice"


class NotOrientable(PatternFault):
    """The seams turn a panel inside out (a Moebius band); exchange the sides of one stitch."""

    code = "pattern.not_orientable"


class MeshTooCoarse(PatternFault):
    """The panels are too narrow for this edge length; raise vertex_count."""

    code = "pattern.too_coarse"


class PatternMismatch(PatternFault):
    """The two patterns differ in panels or control points; use variants of one template."""

    code = "pattern.mismatch"


class SeamUnequal(PatternFault):
    """The sides of a seam differ in length; make them equal, or mark the seam as gathered."""

    code = "pattern.seam_unequal"


class PanelLoose(PatternFault):
    """A panel is sewn to nothing; sew it, or remove it."""

    code = "pattern.panel_loose"
