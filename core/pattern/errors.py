"""What can be wrong with a pattern, one stable code each."""

from __future__ import annotations

from ..errors import BadInput


class PatternUnreadable(BadInput):
    """The pattern file cannot be read; give a GarmentCode or NeuralTailor pattern as JSON."""

    code = "pattern.unreadable"


class PatternTooLarge(BadInput):
    """The pattern file is larger than a garment needs; see docs/pattern.md for the caps."""

    code = "pattern.too_large"


class PatternIncomplete(BadInput):
    """The pattern file lacks a key that the GarmentCode format requires; export it again from its program."""

    code = "pattern.incomplete"


class PatternUnitsMissing(BadInput):
    """The pattern file does not say its units; add properties.units_in_meter (100 for centimetres)."""

    code = "pattern.units_missing"


class PatternValueBad(BadInput):
    """A value in the pattern file has the wrong type or is out of range."""

    code = "pattern.value_bad"


class PanelOpen(BadInput):
    """The edges of a panel do not form one closed loop; each vertex must end one edge and start one other."""

    code = "pattern.open_loop"


class PanelCrossing(BadInput):
    """The outline of a panel crosses itself; redraw it as a simple closed loop."""

    code = "pattern.self_crossing"


class PanelDegenerate(BadInput):
    """A panel has no area, or an edge no length; remove it from the pattern."""

    code = "pattern.degenerate"


class SeamUnknown(BadInput):
    """A stitch names a panel or an edge that the pattern does not have."""

    code = "pattern.seam_unknown"


class SeamTwice(BadInput):
    """An edge takes part in two stitches; split the edge so that each part is sewn once."""

    code = "pattern.edge_sewn_twice"


class NotOrientable(BadInput):
    """The seams turn a panel inside out (a Moebius band); exchange the sides of one stitch."""

    code = "pattern.not_orientable"


class MeshTooCoarse(BadInput):
    """The panels are too narrow for this edge length; raise vertex_count."""

    code = "pattern.too_coarse"


class PatternMismatch(BadInput):
    """The two patterns differ in panels or control points; use variants of one template."""

    code = "pattern.mismatch"
