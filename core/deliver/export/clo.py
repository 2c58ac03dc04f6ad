"""Write a sewn pattern for CLO and Marvelous Designer: a document, and a program for their own interpreters.

The document's fields follow public notes and CLO's public header; neither program was run.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from ...cloth.fabric import Fabric
from ...garment.curves import chord, edge_length, edge_points, is_flat_arc, panel_outline, place_on_chord, unit_circle
from ...garment.pattern import Edge, EdgeRef, Panel, Pattern
from ...garment.pieces.shelf_packing import pack_on_shelves
from ...garment.seams import equalise_seams
from ...run.errors import BadInput
from ...run.units import MM_PER_M
from .sewn_mesh import sanitise_names

POSITION_DECIMAL_COUNT = 5
"""Number of decimals of a position in millimetres: the error of seam lengths is far below 0.05 mm."""

MIN_CLO_SEAM_LENGTH = 3e-3
"""Shortest seam that is written [m]. Shorter ones made Marvelous Designer drop all seams of a file."""

MIN_CLO_EDGE_LENGTH = 5e-4
"""Shortest edge of a piece that is written [m]: ten times the edge for which Marvelous Designer drops all seams."""

MAX_CLO_SEAM_MISMATCH = 5e-5
"""Largest difference in length of the two sides of a seam that is not gathered [m]."""

PATTERN_WINDOW_GAP = 0.1
"""Space between pieces in the pattern window [m]."""

PATTERN_WINDOW_WIDTH = 2.0
"""Width of the pattern window's layout [m]."""

MAX_BEZIER_ARC_ANGLE = np.pi / 4.0
"""Largest angle of an arc that is drawn as one cubic Bezier curve [rad]; the error is 4e-7 of the radius."""

SPLINE_POINT_COUNT_RANGE = (4, 24)
"""Smallest and largest number of points of a curve between its ends, where the program draws the pieces point by point;
fewer than 4 do not keep a curve's form."""

SPLINE_POINT_SPACING = 0.01
"""Distance between such points along the curve [m]."""


class SeamUnsewable(BadInput):
    """A seam cannot be written for this program; mend the pattern's seam and export again."""

    code = "export.seam_unsewable"


@dataclass(frozen=True)
class _PlacedPiece:
    """Describe a piece in the pattern window: its panel, plain name, and the panel's origin there [m], shape [2]."""

    panel: Panel
    name: str
    origin: np.ndarray


def write_clo(pattern: Pattern, fabric: Fabric, folder: Path, stem: str) -> list[Path]:
    """Write `STEM.clo.json` and `STEM_clo.py`.

    Both have the net panels, in millimetres, y up, and the seams, whose sides `equalise_seams` first makes equal.

    Raises:
        SeamUnsewable: where a seam is shorter than `MIN_CLO_SEAM_LENGTH` or an edge than `MIN_CLO_EDGE_LENGTH`, a
            seam's sides differ by more than `MAX_CLO_SEAM_MISMATCH`, or it joins an edge to itself.
    """
    sewn = equalise_seams(pattern)
    _check_seams(sewn)
    placed = _place(sewn)
    document = json.dumps(clo_document(sewn, fabric, placed), indent=1)
    points = json.dumps(_point_lists(sewn, placed))
    program = files(__package__).joinpath("programs/clo.py").read_text(encoding="utf-8")
    program = program.replace('DOCUMENT = "{}"', f"DOCUMENT = {document!r}")
    program = program.replace('POINTS = "{}"', f"POINTS = {points!r}")
    paths = [folder / f"{stem}.clo.json", folder / f"{stem}_clo.py"]
    paths[0].write_text(document + "\n", encoding="utf-8")
    paths[1].write_text(program, encoding="utf-8")
    return paths


def _check_seams(pattern: Pattern) -> None:
    for panel in pattern.panels:
        short = min(range(len(panel.edges)), key=lambda edge: edge_length(panel, edge))
        if edge_length(panel, short) < MIN_CLO_EDGE_LENGTH:
            raise SeamUnsewable(
                f"edge {short} of '{panel.name}' is {MM_PER_M * edge_length(panel, short):.3f} mm long; "
                f"the program takes none below {MM_PER_M * MIN_CLO_EDGE_LENGTH:g} mm: merge it with its neighbour."
            )
    for seam in pattern.seams:
        sides = [f"edge {ref.edge} of '{ref.panel}'" for ref in (seam.a, seam.b)]
        if seam.a == seam.b:
            raise SeamUnsewable(f"{sides[0]} is sewn to itself; sew it to another edge.")
        lengths = [edge_length(pattern.panel(ref.panel), ref.edge) for ref in (seam.a, seam.b)]
        if min(lengths) < MIN_CLO_SEAM_LENGTH:
            raise SeamUnsewable(
                f"the seam of {' and '.join(sides)} is {MM_PER_M * min(lengths):.2f} mm long; "
                f"the program takes none below {MM_PER_M * MIN_CLO_SEAM_LENGTH:.0f} mm: merge it with its neighbour."
            )
        if not seam.gathered and abs(lengths[0] - lengths[1]) > MAX_CLO_SEAM_MISMATCH:
            raise SeamUnsewable(
                f"the sides of the seam of {' and '.join(sides)} differ by "
                f"{MM_PER_M * abs(lengths[0] - lengths[1]):.2f} mm; make them equal, or mark the seam as gathered."
            )


def _place(pattern: Pattern) -> list[_PlacedPiece]:
    """Arrange the panels side by side in the pattern window."""
    outlines = [panel_outline(panel) for panel in pattern.panels]
    low = np.array([outline.min(axis=0) for outline in outlines])
    corners = pack_on_shelves(
        np.array([np.ptp(outline, axis=0) for outline in outlines]), PATTERN_WINDOW_GAP, PATTERN_WINDOW_WIDTH
    )
    names = sanitise_names([panel.name for panel in pattern.panels])
    return [
        _PlacedPiece(panel, name, corner - start)
        for panel, name, corner, start in zip(pattern.panels, names, corners, low, strict=True)
    ]


def clo_document(pattern: Pattern, fabric: Fabric, placed: list[_PlacedPiece]) -> dict[str, Any]:
    """Return the pattern document as JSON values."""
    cloth = "gq_fabric_0"
    pieces: list[dict[str, Any]] = []
    spans: dict[EdgeRef, dict[str, Any]] = {}
    for number, piece in enumerate(placed):
        lines, found = _draw_lines(piece, number)
        pieces.append(_describe_piece(piece, f"gq_{number}", lines, cloth))
        spans |= found
    return {
        "Unit": "mm",
        "FabricList": [
            {
                "FabricName": sanitise_names([fabric.name])[0], "FabricUUID": cloth, "FabricType": "None",
                "FabricContent": "None", "strBaseColorHexCode": "#FFFFFF",
            }
        ],
        "PatternList": pieces,
        "SymmetricDataList": [{"OriginPatternID": each["ID"], "SymmetricPatternID": "None"} for each in pieces],
        "InstanceDataList": [{"OriginPatternID": each["ID"], "InstancePatternIDArray": []} for each in pieces],
        "GradingRuleTableList": [],
        "POMList": [],
        "SeamLinePairGroupList": [
            {
                "Name": f"seam_{number}",
                "bIsTurned": False,
                "FoldData": {"iAngle": 180, "iStrength": 5},
                "PairList": [{"First": _span(spans[seam.a], False), "Second": _span(spans[seam.b], seam.reversed)}],
            }
            for number, seam in enumerate(pattern.seams)
        ],
    }  # fmt: skip


def _describe_piece(piece: _PlacedPiece, key: str, lines: list[dict[str, Any]], cloth: str) -> dict[str, Any]:
    return {
        "Name": piece.name,
        "ID": key,
        "CurrentFabricUUID": cloth,
        "fGrainlineAngle": round(float(np.degrees(piece.panel.grainline)), 4),
        "strGrainlineOrientation": "One Way",
        "strSuperImposeSide": "None",
        "IsClosed": True,
        "IsHalfSymmetric": False,
        "InternalLineList": [],
        "ButtonHeadList": [],
        "ButtonHoleList": [],
        "AnnotationList": [],
        "NotchList": [],
        "OuterSeamAllowanceList": [],
        "ShapeInfo": {"IsSlashed": False, "LineList": lines},
        "ArrangementPointDataMap": {"PointName": "Arrangement Point", "fOffSetX": 0.0, "fOffSetY": 0.0, "fAngle": 0.0},
    }


def _draw_lines(piece: _PlacedPiece, number: int) -> tuple[list[dict[str, Any]], dict[EdgeRef, dict[str, Any]]]:
    """Return a piece's lines, and the span of each edge in the outline's length."""
    panel = piece.panel
    lines: list[np.ndarray] = []
    whole = sum(edge_length(panel, edge) for edge in range(len(panel.edges)))
    spans: dict[EdgeRef, dict[str, Any]] = {}
    done = 0.0
    for edge in range(len(panel.edges)):
        first = len(lines)
        for controls in edge_cubics(panel, edge):
            lines.append(MM_PER_M * (controls + piece.origin))
        length = edge_length(panel, edge)
        end = 1.0 if edge == len(panel.edges) - 1 else (done + length) / whole
        spans[EdgeRef(panel.name, edge)] = {
            "shape": f"gq_{number}", "start": done / whole, "end": end,
            "first": f"gq_{number}_line_{first}", "last": f"gq_{number}_line_{len(lines) - 1}",
        }  # fmt: skip
        done += length
    seams = []
    for index, controls in enumerate(lines):
        keys = [f"gq_{number}_point_{index}"]
        keys += [f"gq_{number}_handle_{index}_{handle}" for handle in range(len(controls) - 2)]
        keys.append(f"gq_{number}_point_{(index + 1) % len(lines)}")
        kinds = ["Straight", *["Bezier Curve"] * (len(controls) - 2), "Straight"]
        seams.append(
            {
                "ID": f"gq_{number}_line_{index}",
                "PointList": [
                    {
                        "ID": key,
                        "PointType": kind,
                        "Position": {
                            "x": round(float(x), POSITION_DECIMAL_COUNT),
                            "y": round(float(y), POSITION_DECIMAL_COUNT),
                        },
                        "GradingRuleID": 0,
                    }
                    for key, kind, (x, y) in zip(keys, kinds, controls, strict=True)
                ],
            }
        )
    return seams, spans


def _span(span: dict[str, Any], is_backward: bool) -> dict[str, Any]:
    """Return a seam's side: a span of the outline's length, from its start or back from its end."""
    start, end = (span["end"], span["start"]) if is_backward else (span["start"], span["end"])
    return {
        "ShapeID": span["shape"],
        "LineID": span["last"] if is_backward else span["first"],
        "LengthParam": {"fStart": round(start, 9), "fEnd": round(end, 9)},
        "Direction": not is_backward,
    }


def edge_cubics(panel: Panel, edge: int) -> list[np.ndarray]:
    """Return an edge as lines, shape [2, 2], or cubics by their four control points, shape [4, 2] [m], end to end. A
    quadratic is raised to a cubic exactly; an arc is cut into turns of at most `MAX_BEZIER_ARC_ANGLE`, each a cubic
    with handles of length 4/3 tan(turn / 4) of the radius."""
    kind, start_end = panel.edges[edge], chord(panel, edge)
    if kind.kind == "line" or is_flat_arc(kind):
        return [np.stack(start_end)]
    if kind.kind == "arc":
        return [place_on_chord(controls, *start_end) for controls in _arc_cubics(kind)]
    handles = place_on_chord(kind.handles, *start_end)
    start, end = start_end
    if len(handles) == 1:
        handles = np.stack([start + 2.0 / 3.0 * (handles[0] - start), end + 2.0 / 3.0 * (handles[0] - end)])
    return [np.stack([start, *handles, end])]


def _arc_cubics(edge: Edge) -> list[np.ndarray]:
    centre, radius, first, sweep = unit_circle(edge)
    count = max(1, int(np.ceil(abs(sweep) / MAX_BEZIER_ARC_ANGLE - 1e-9)))
    angles = first + sweep * np.arange(count + 1) / count
    handle = 4.0 / 3.0 * np.tan(sweep / count / 4.0)
    points = centre + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points[0], points[-1] = (0.0, 0.0), (1.0, 0.0)
    along = radius * handle * np.stack([-np.sin(angles), np.cos(angles)], axis=1)
    return [
        np.stack([points[n], points[n] + along[n], points[n + 1] - along[n + 1], points[n + 1]]) for n in range(count)
    ]


def _point_lists(pattern: Pattern, placed: list[_PlacedPiece]) -> dict[str, Any]:
    """Return pieces as corners (0) and points of splines (2) [mm], and seams by piece and line."""
    pieces, names = [], {piece.panel.name: piece.name for piece in placed}
    for piece in placed:
        points: list[list[float]] = []
        for edge in range(len(piece.panel.edges)):
            kind = piece.panel.edges[edge]
            is_straight = kind.kind == "line" or is_flat_arc(kind)
            point_count = int(np.ceil(edge_length(piece.panel, edge) / SPLINE_POINT_SPACING))
            inner = 0 if is_straight else int(np.clip(point_count, *SPLINE_POINT_COUNT_RANGE))
            along = np.round(
                MM_PER_M * (edge_points(piece.panel, edge, inner + 1)[:-1] + piece.origin), POSITION_DECIMAL_COUNT
            )
            points += [[x, y, 2 if n else 0] for n, (x, y) in enumerate(along.tolist())]
        pieces.append({"name": piece.name, "points": points})

    def side(ref: EdgeRef, is_forward: bool) -> dict[str, Any]:
        return {"piece": names[ref.panel], "line": ref.edge, "forward": is_forward}

    seams = [{"a": side(seam.a, True), "b": side(seam.b, not seam.reversed)} for seam in pattern.seams]
    return {"pieces": pieces, "seams": seams}
