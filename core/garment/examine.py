"""Check a pattern's document: find all faults that prevent cutting, sewing and meshing, each with its place."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from ..run.units import MM_PER_M
from .curves import edge_length, panel_area
from .errors import PanelLoose, PatternFault, Place, SeamUnequal
from .garmentcode import GATHER_TOLERANCE, parse_document, read_bytes, read_numbered
from .json_values import get_object
from .numbering import Numbering, renumber
from .pattern import Panel, Pattern
from .seams import seam_lengths
from .sewing import mesh_pattern
from .symmetry import find_symmetry
from .validity import check_outline

SEAM_MISMATCH_TOLERANCE = 0.5e-3
"""Reported difference between the lengths of a seam's sides [m]: the limit of the verdict on seams."""

TRIAL_MESH_VERTEX_COUNT = 1500
"""Number of nodes of the trial mesh, as in the first drape of a pattern."""

CM2_PER_M2 = 1e4
"""Number of square centimetres in a square metre."""


class Severity(StrEnum):
    """Severity of a finding: an error prevents draping."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True)
class Finding:
    """Describe one fault of a pattern.

    Attributes:
        code: Stable, `pattern.*`.
        severity: Whether the pattern can still be draped.
        message: Text for the user.
        seam: Number of the seam, or None.
    """

    code: str
    severity: Severity
    message: str
    seam: int | None = None
    places: tuple[Place, ...] = ()

    @classmethod
    def of(cls, fault: PatternFault, severity: Severity = Severity.ERROR) -> Finding:
        """Return an error as a finding."""
        return cls(fault.code, severity, fault.message, fault.seam, fault.places)


def find_faults(pattern: Pattern, vertex_count: int = TRIAL_MESH_VERTEX_COUNT) -> tuple[Finding, ...]:
    """Find the faults of a pattern: outlines, seams, and where these are sound, its mesh.

    Args:
        pattern: What to examine.
        vertex_count: Nodes of the trial mesh.
    """
    found = [Finding.of(fault) for fault in _catch(check_outline, pattern.panels)]
    found += _examine_seams(pattern)
    if any(one.severity is Severity.ERROR for one in found):
        return tuple(found)
    return (*found, *(Finding.of(fault) for fault in _catch(lambda one: mesh_pattern(one, vertex_count), [pattern])))


def _catch(check: Callable[[Any], object], values: Iterable[Any]) -> list[PatternFault]:
    """Return the faults that a check raises for each of some values."""
    found = []
    for one in values:
        try:
            check(one)
        except PatternFault as fault:
            found.append(fault)
    return found


def _examine_seams(pattern: Pattern) -> list[Finding]:
    """Find seams whose sides are unequal without being gathered, and panels without a seam."""
    found = []
    for number, (seam, (a, b)) in enumerate(zip(pattern.seams, seam_lengths(pattern), strict=True)):
        if seam.gathered or abs(a - b) <= SEAM_MISMATCH_TOLERANCE:
            continue
        message = (
            f"the sides of seam {number} differ by {MM_PER_M * abs(a - b):.1f} mm "
            f"({MM_PER_M * a:.1f} and {MM_PER_M * b:.1f} mm); make them equal, or mark the seam as gathered."
        )
        places = [Place(ref.panel, edge=ref.edge) for ref in (seam.a, seam.b)]
        is_far = b == 0.0 or abs(a / b - 1.0) > GATHER_TOLERANCE
        fault = SeamUnequal(message, *places, seam=number)
        found.append(Finding.of(fault, Severity.ERROR if is_far else Severity.WARNING))
    sewn = {ref.panel for seam in pattern.seams for ref in (seam.a, seam.b)}
    for panel in pattern.panels:
        if len(pattern.panels) > 1 and panel.name not in sewn:
            message = f"panel '{panel.name}' is sewn to nothing; sew it, or remove it."
            found.append(Finding.of(PanelLoose(message, Place(panel.name))))
    return found


def examine_file(source: str, vertex_count: int = TRIAL_MESH_VERTEX_COUNT) -> dict[str, Any]:
    """Check a pattern file in a limited process, and return findings and measurements, as JSON values.

    Args:
        source: Path of the file.
        vertex_count: Nodes of the trial mesh.

    Returns:
        `is_sound`, `findings`, `panels`, `seams` and `mirrors` (docs/reference/pattern-documents.md). Numbers of edges
            and control points are the file's, points are in its unit.

    Raises:
        PatternFault: where the file is no JSON object.
    """
    return examine_pattern(get_object(parse_document(read_bytes(Path(source))), "the file"), vertex_count)


def examine_pattern(document: dict[str, Any], vertex_count: int = TRIAL_MESH_VERTEX_COUNT) -> dict[str, Any]:
    """Check a pattern's document as `examine_file` does.

    Args:
        document: The parsed document.
        vertex_count: Nodes of the trial mesh.
    """
    try:
        pattern, numbers = read_numbered(document, is_checked=False)
    except PatternFault as fault:
        return _make_report([Finding.of(fault)])
    findings = [_to_file_numbering(one, pattern, numbers) for one in find_faults(pattern, vertex_count)]
    return _make_report(
        findings,
        panels=[_describe_panel(panel, numbers[panel.name]) for panel in pattern.panels],
        seams=_describe_seams(pattern, numbers),
        mirrors=_describe_mirrors(pattern, numbers),
    )


def _make_report(findings: list[Finding], **measured: Any) -> dict[str, Any]:
    is_sound = all(one.severity is not Severity.ERROR for one in findings)
    empty: dict[str, Any] = {"panels": [], "seams": [], "mirrors": []}
    return {"is_sound": is_sound, "findings": [asdict(one) for one in findings]} | empty | measured


def _to_file_numbering(finding: Finding, pattern: Pattern, numbers: dict[str, Numbering]) -> Finding:
    """Return a finding with the file's numbers, and points in its unit and its panels' axes."""
    per_metre = float(pattern.extra["units_in_meter"])
    places = []
    for place in finding.places:
        filed = renumber(place, numbers[place.panel])
        if place.point is not None:
            x, y = place.point
            side = -1.0 if pattern.panel(place.panel).mirrored else 1.0
            filed = replace(filed, point=(side * x * per_metre, y * per_metre))
        places.append(filed)
    return replace(finding, places=tuple(places))


def _describe_panel(panel: Panel, numbers: Numbering) -> dict[str, Any]:
    lengths = [0.0] * len(panel.edges)
    for index, number in enumerate(numbers.edges):
        lengths[number] = MM_PER_M * edge_length(panel, index)
    return {"panel": panel.name, "area_cm2": CM2_PER_M2 * panel_area(panel), "edges_mm": lengths}


def _describe_seams(pattern: Pattern, numbers: dict[str, Numbering]) -> list[dict[str, Any]]:
    found = []
    for seam, (a, b) in zip(pattern.seams, MM_PER_M * seam_lengths(pattern), strict=True):
        sides = {
            side: {"panel": ref.panel, "edge": numbers[ref.panel].edges[ref.edge]}
            for side, ref in (("a", seam.a), ("b", seam.b))
        }
        measured = {"lengths_mm": [float(a), float(b)], "mismatch_mm": float(a - b), "is_gathered": seam.gathered}
        found.append({**sides, **measured})
    return found


def _describe_mirrors(pattern: Pattern, numbers: dict[str, Numbering]) -> list[dict[str, Any]]:
    """Return the pairs of mirrored panels with their pairs of control points, and `matrix`, which maps the move of a
    control point to that of its image in the target, in the file's axes."""
    found = []
    for mirror in find_symmetry(pattern).mirrors:
        source, target = pattern.panels[mirror.source], pattern.panels[mirror.target]
        numbers_of_source, numbers_of_target = (numbers[panel.name].vertices for panel in (source, target))
        pairs = [[numbers_of_source[int(i)], numbers_of_target[j]] for j, i in enumerate(mirror.order)]
        sides = [np.diag([-1.0 if panel.mirrored else 1.0, 1.0]) for panel in (source, target)]
        matrix = sides[1] @ mirror.rotation @ sides[0]
        found.append({"source": source.name, "target": target.name, "vertices": pairs, "matrix": matrix.tolist()})
    return found
