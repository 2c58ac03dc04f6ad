"""Apply a list of operations, as JSON values, to a pattern's document."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import PatternFault, Place
from ..examine import Finding, examine_pattern
from ..garmentcode import load_pattern, write_pattern
from ..json_values import get_index, get_list, get_number, get_object, get_text, get_vector
from ..pattern import Pattern
from ..seams import equalise_seams
from .cutting import cut_panel
from .edge_division import merge_edges, split_edges
from .errors import EditBad
from .joining import join_panels
from .move_points import move_points
from .partners import check_number, find_panel
from .reshaping import sharpen_corner, smooth_corner, straighten_edges

MAX_EDIT_OPERATIONS = 1000
"""Largest number of operations in one list: a pattern maker does some hundreds in an hour."""

MAX_POINT_MOVE_MM = 10_000.0
"""Largest motion of a point [mm]."""

MAX_OPERATION_NUMBER = 100_000
"""Largest number in an operation; the operation checks it against the panel."""

OperationFields = Mapping[str, Any]


def apply_operations(pattern: Pattern, operations: list[Any]) -> Pattern:
    """Return a pattern after operations, one after the other; docs/reference/http.md has their fields.

    Args:
        pattern: The pattern.
        operations: JSON objects, each with `op`. Numbers are those of the pattern after the operations before,
            coordinates those of its file's axes.

    Raises:
        EditBad: where one is unknown or cannot be done; the message begins with its number.
        PatternFault: where one has a value of a wrong type.
    """
    if len(operations) > MAX_EDIT_OPERATIONS:
        raise EditBad(f"{len(operations)} operations; at most {MAX_EDIT_OPERATIONS} are done at once.")
    for number, operation in enumerate(operations):
        where = f"operation {number}"
        one = get_object(operation, where)
        name = get_text(one.get("op", ""), f"{where} op")
        if name not in OPERATIONS:
            raise EditBad(f"{where}: there is no '{name[:40]}'; there are {', '.join(OPERATIONS)}.")
        fields, apply = OPERATIONS[name]
        wrong = sorted(set(one) - {"op", *fields})
        if wrong:
            raise EditBad(f"{where}: '{name}' takes no '{wrong[0][:40]}'; it takes {', '.join(fields)}.")
        try:
            pattern = apply(pattern, one)
        except KeyError as missing:
            raise EditBad(f"{where}: '{name}' needs '{missing.args[0]}'.") from None
        except PatternFault as fault:
            fault.message = f"{where}: {fault.message}"
            raise
    return pattern


def edit_file(source: str, operations: str) -> dict[str, Any]:
    """Apply operations to a pattern file in a limited process.

    Args:
        source: Path of the document.
        operations: Path of a JSON list.

    Returns:
        `pattern`, the new document, with the results of `examine_file` for it; or `refused`, a finding with the
            operation that cannot be done, and its place, or with what is wrong with the document.
    """
    parsed = json.loads(Path(operations).read_text(encoding="utf-8"))
    try:
        document = write_pattern(apply_operations(load_pattern(source), get_list(parsed, "operations")))
    except PatternFault as fault:
        return {"refused": asdict(Finding.of(fault))}
    return {"pattern": document} | examine_pattern(document)


def _corner(pattern: Pattern, fields: OperationFields) -> tuple[str, int]:
    panel = find_panel(pattern, get_text(fields["panel"], "panel"))
    number = get_index(fields["vertex"], MAX_OPERATION_NUMBER, "vertex")
    check_number(panel, number)
    return panel.name, number


def _to_panel_axes(pattern: Pattern, panel: str, vectors: Any, name: str) -> np.ndarray:
    """Return lengths [mm] in the axes of a panel's file as lengths [m] in the panel's axes here."""
    side = -1.0 if find_panel(pattern, panel).mirrored else 1.0
    found = np.array(get_vector(vectors, 2, name, MAX_POINT_MOVE_MM)) / 1e3
    moves: np.ndarray = found * np.array([side, 1.0])
    return moves


def _move(pattern: Pattern, fields: OperationFields) -> Pattern:
    corners = [_corner(pattern, get_object(one, "point")) for one in get_list(fields["points"], "points")]
    names = {name for name, _ in corners}
    if len({pattern.panel(name).mirrored for name in names}) > 1:
        raise EditBad("panels that the file draws from different sides are moved one after the other.")
    if not corners:
        return pattern
    displacement = _to_panel_axes(pattern, corners[0][0], fields["by_mm"], "by_mm")
    return move_points(pattern, corners, displacement, *_read_keep_flags(fields))


def _read_keep_flags(fields: OperationFields) -> tuple[bool, bool]:
    """Return whether mirror images follow, and whether the seams stay equal; both default to True."""
    found = []
    for name in ("keep_symmetry", "keep_seams"):
        value = fields.get(name, True)
        if not isinstance(value, bool):
            raise EditBad(f"{name} is true or false.")
        found.append(value)
    return found[0], found[1]


def _straighten(pattern: Pattern, fields: OperationFields) -> Pattern:
    panel = get_text(fields["panel"], "panel")
    first, last = (get_index(fields[name], MAX_OPERATION_NUMBER, name) for name in ("from", "to"))
    return straighten_edges(pattern, panel, first, last, *_read_keep_flags(fields))


def _smooth(pattern: Pattern, fields: OperationFields) -> Pattern:
    return smooth_corner(pattern, *_corner(pattern, fields), *_read_keep_flags(fields))


def _sharpen(pattern: Pattern, fields: OperationFields) -> Pattern:
    return sharpen_corner(pattern, *_corner(pattern, fields), *_read_keep_flags(fields))


def _split(pattern: Pattern, fields: OperationFields) -> Pattern:
    panel, edge = get_text(fields["panel"], "panel"), get_index(fields["edge"], MAX_OPERATION_NUMBER, "edge")
    return split_edges(
        pattern, panel, edge, get_number(fields.get("at", 0.5), "at", 0.0, 1.0), _read_keep_flags(fields)[0]
    )


def _merge(pattern: Pattern, fields: OperationFields) -> Pattern:
    return merge_edges(pattern, *_corner(pattern, fields), _read_keep_flags(fields)[0])


def _cut(pattern: Pattern, fields: OperationFields) -> Pattern:
    panel = get_text(fields["panel"], "panel")
    ends = get_list(fields["line_mm"], "line_mm")
    if len(ends) != 2:
        raise EditBad("line_mm has two points.", Place(panel))
    return cut_panel(pattern, panel, np.array([_to_panel_axes(pattern, panel, end, "line_mm") for end in ends]))


def _join(pattern: Pattern, fields: OperationFields) -> Pattern:
    return join_panels(pattern, get_index(fields["seam"], MAX_OPERATION_NUMBER, "seam"))


def _equalise(pattern: Pattern, fields: OperationFields) -> Pattern:
    fixed = [_corner(pattern, get_object(one, "fixed")) for one in get_list(fields.get("fixed", []), "fixed")]
    return equalise_seams(pattern, fixed=fixed)


KEEP = ("keep_symmetry", "keep_seams")
OPERATIONS: dict[str, tuple[tuple[str, ...], Callable[[Pattern, OperationFields], Pattern]]] = {
    "move": (("points", "by_mm", *KEEP), _move),
    "straighten": (("panel", "from", "to", *KEEP), _straighten),
    "smooth": (("panel", "vertex", *KEEP), _smooth),
    "sharpen": (("panel", "vertex", *KEEP), _sharpen),
    "split": (("panel", "edge", "at", "keep_symmetry"), _split),
    "merge": (("panel", "vertex", "keep_symmetry"), _merge),
    "cut": (("panel", "line_mm"), _cut),
    "join": (("seam",), _join),
    "equalise": (("fixed",), _equalise),
}
"""Fields and function of each operation."""
