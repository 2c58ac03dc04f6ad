"""Read the pattern JSON of GarmentCode and of NeuralTailor's generator. Lengths are in the file's own unit
(`properties.units_in_meter` per metre). Curves are a list [x, y] (one quadratic handle, older files) or {type:
quadratic | cubic | circle, params}. Placement is a translation and Euler angles in degrees about the fixed axes x, y, z
in this order. GarmentCode's writer uses moving axes while its mesher and every other reader use fixed ones; published
patterns mostly turn about one axis or by half turns, where both agree."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..run.text import has_unstorable_text
from .curves import edge_length, panel_area, reverse_edge
from .errors import (
    NotOrientable,
    PanelDegenerate,
    PanelOpen,
    PatternIncomplete,
    PatternTooLarge,
    PatternUnitsMissing,
    PatternUnreadable,
    PatternValueBad,
    Place,
    SeamTwice,
    SeamUnknown,
)
from .garmentcode_writer import EXTENSION_KEY, save_pattern, write_pattern
from .grain import place_grains
from .json_values import get_index, get_list, get_number, get_object, get_text, get_vector
from .numbering import Numbering, renumber
from .orientation import agree_orientation, mirror_panel
from .pattern import Edge, EdgeRef, Panel, Pattern, Seam
from .pattern_units import check_pattern_units
from .validity import check_outline

__all__ = ["load_pattern", "read_pattern", "save_pattern", "write_pattern"]

MAX_BYTES = 10_000_000
"""Largest size of a pattern file [bytes]; published patterns have 5 to 300 kB."""
MAX_PANELS = 200
"""Largest number of panels; the largest published garments have about 60."""
MAX_EDGES = 2000
"""Largest number of edges of a pattern."""
MAX_CATEGORY_LENGTH = 32
"""Largest length of a category [characters]; those in use are shorter."""
MAX_SIZE = 50.0
"""Largest coordinate or translation [m]; beyond it the file's unit is wrong."""
GATHER_TOLERANCE = 0.03
"""Difference [1] of a seam's length ratio from 1 above which it is gathered."""
RADIUS_SLACK = 1e-3
"""Share by which a radius may be shorter than half the chord from rounding; the arc is then a half circle."""


def load_pattern(path: str | Path) -> Pattern:
    """Read a pattern file.

    Raises:
        BadInput: with a code `pattern.*` and one clear line, whatever the file contains.
    """
    path = Path(path)
    return read_pattern(read_bytes(path), name=path.stem.removesuffix("_specification"))


def read_bytes(path: Path) -> bytes:
    """Read the bytes of a pattern file; at most `MAX_BYTES` + 1, so that `parse_document` finds a file too large.

    Raises:
        PatternUnreadable: where it cannot be opened.
    """
    try:
        with path.open("rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise PatternUnreadable(f"the pattern file {path.name} cannot be opened; check its path.") from error


def read_pattern(source: dict[str, Any] | str | bytes, name: str = "pattern") -> Pattern:
    """Read a pattern from its JSON text or from the parsed object. Clockwise panels are mirrored (see
    `orientation.mirror_panel`) and marked; `write_pattern` restores them.

    Raises:
        BadInput: with a code `pattern.*` and one clear line, whatever the source contains.
    """
    return read_numbered(source, name)[0]


def read_numbered(
    source: dict[str, Any] | str | bytes, name: str = "pattern", is_checked: bool = True
) -> tuple[Pattern, dict[str, Numbering]]:
    """Read a pattern as `read_pattern` does, and return also the file's numbering of each panel, by its name.

    Args:
        source: JSON text, or the parsed object.
        name: Name of the pattern.
        is_checked: False accepts panels whose outline crosses itself or has no area.

    Raises:
        PatternFault: with the place, in the file's numbers.
    """
    top = get_object(parse_document(source) if isinstance(source, str | bytes) else source, "the file")
    if has_unstorable_text(top):
        raise PatternValueBad("a text in the pattern file holds NUL or half of a surrogate pair; write it as UTF-8.")
    if "pattern" not in top:
        raise PatternIncomplete("the file has no key 'pattern': it is no GarmentCode or NeuralTailor pattern.")
    body = get_object(top["pattern"], "pattern")
    properties = get_object(top.get("properties", {}), "properties")
    if "units_in_meter" not in properties:
        raise PatternUnitsMissing
    scale = 1.0 / get_number(properties["units_in_meter"], "properties.units_in_meter", low=1e-3, high=1e5)
    if "panels" not in body:
        raise PatternIncomplete("pattern.panels is missing; the file holds no panels.")
    files = get_object(body["panels"], "pattern.panels")
    if not files:
        raise PatternIncomplete("pattern.panels is empty; a garment needs at least one panel.")
    if len(files) > MAX_PANELS:
        raise PatternTooLarge(f"the pattern has {len(files)} panels; at most {MAX_PANELS} are read.")
    edge_lists = [file.get("edges") for file in files.values() if isinstance(file, dict)]
    if sum(len(edges) for edges in edge_lists if isinstance(edges, list)) > MAX_EDGES:
        raise PatternTooLarge(f"the pattern has more than {MAX_EDGES} edges.")
    relative = properties.get("curvature_coords", "relative") != "absolute"
    extension = properties.get(EXTENSION_KEY, {}) if isinstance(properties.get(EXTENSION_KEY, {}), dict) else {}
    panels, unknown = [], {}
    found: dict[str, Numbering] = {}
    numbers: dict[str, dict[int, int]] = {}
    for panel_name, file in files.items():
        get_text(panel_name, "a panel's name")
        panel, own_numbers, rest = _read_panel(panel_name, get_object(file, f"panel '{panel_name}'"), scale, relative)
        if is_checked:
            check_outline(panel)
        panels.append(panel)
        found[panel_name] = own_numbers
        numbers[panel_name] = {old: new for new, old in enumerate(own_numbers.edges)}
        unknown[panel_name] = rest
    if not extension:
        check_pattern_units(panels, properties)
    seams = _read_seams(get_list(body.get("stitches", []), "pattern.stitches"), numbers)
    extra = {
        "units_in_meter": properties["units_in_meter"],
        "properties": {key: value for key, value in properties.items() if key not in ("units_in_meter", EXTENSION_KEY)},
        "top": {key: value for key, value in top.items() if key not in ("pattern", "properties")},
        "pattern": {key: value for key, value in body.items() if key not in ("panels", "stitches")},
        "panels": unknown,
    }
    category = extension.get("category", "")
    category = get_text(category, "the category", MAX_CATEGORY_LENGTH) if isinstance(category, str) else ""
    pattern = Pattern(name, tuple(panels), seams, category, extra)
    read, grained = _restore_extensions(pattern, extension)
    if extension and all(seam.reversed for seam in seams):  # written by `write_pattern`, with consistent panels
        return place_grains(_mark_gathers(read, extension), grained), found
    try:
        agreed = agree_orientation(read)
    except NotOrientable as error:
        places = [renumber(place, found[place.panel]) for place in error.places]
        raise NotOrientable(None, *places, seam=error.seam) from None
    for panel, now in zip(read.panels, agreed.panels, strict=True):
        if panel.mirrored != now.mirrored:  # turned over: its loop is reversed, from the same point
            before = found[panel.name]
            found[panel.name] = Numbering(before.edges[::-1], (before.vertices[0], *before.vertices[:0:-1]))
    return place_grains(_mark_gathers(agreed, extension), grained), found


def parse_document(source: str | bytes) -> Any:
    """Return the JSON value of a pattern file.

    Raises:
        PatternUnreadable, PatternTooLarge, PatternValueBad: where it is none.
    """
    if len(source) > MAX_BYTES:
        raise PatternTooLarge(f"the pattern file is larger than {MAX_BYTES // 1_000_000} MB; no pattern needs that.")

    def refuse(value: str) -> None:
        raise PatternValueBad(f"the pattern file holds {value}, which is no number.")

    try:
        return json.loads(source, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise PatternUnreadable("the pattern file is not JSON; give a GarmentCode or NeuralTailor pattern.") from error


def _read_panel(
    name: str, file: dict[str, Any], scale: float, relative: bool
) -> tuple[Panel, Numbering, dict[str, Any]]:
    """Read one panel: return it (counter-clockwise), the file's numbering, and unknown keys."""
    where = f"panel '{name}'"
    for key in ("vertices", "edges"):
        if key not in file:
            raise PatternIncomplete(f"{where} has no '{key}'.")
    vertices = [
        get_vector(v, 2, f"{where} vertex", MAX_SIZE / scale) for v in get_list(file["vertices"], f"{where} vertices")
    ]
    if not vertices:
        raise PatternIncomplete(f"{where} has no vertices.")
    points = np.array(vertices) * scale
    edges = [get_object(edge, f"{where} edge") for edge in get_list(file["edges"], f"{where} edges")]
    ends = []
    for number, edge in enumerate(edges):
        if "endpoints" not in edge:
            raise PatternIncomplete(f"{where} edge {number} has no 'endpoints'.")
        pair = get_list(edge["endpoints"], f"{where} edge {number} endpoints")
        if len(pair) != 2:
            raise PatternValueBad(f"{where} edge {number} must have two endpoints.")
        first, last = (get_index(end, len(points), f"{where} edge {number} endpoint") for end in pair)
        ends.append((first, last))
    order, flipped = _order_loop(ends, name)
    starts = [ends[k][int(back)] for k, back in zip(order, flipped, strict=True)]
    loop = points[starts]
    curves, rests = [], {}
    for at, (number, back) in enumerate(zip(order, flipped, strict=True)):
        start, end = loop[at], loop[(at + 1) % len(loop)]
        if np.linalg.norm(end - start) < 1e-6:
            x, y = vertices[starts[at]]
            place = Place(name, edge=number, vertex=starts[at], point=(x, y))
            raise PanelDegenerate(f"{where} edge {number} has no length; remove it.", place)
        drawn = (end, start) if back else (start, end)
        curves.append(_read_edge(edges[number], *drawn, back, scale, relative, f"{where} edge {number}"))
        rest = {key: value for key, value in edges[number].items() if key not in ("endpoints", "curvature", "label")}
        if rest:
            rests[str(at)] = rest
    angles = get_vector(file.get("rotation", [0, 0, 0]), 3, f"{where} rotation", 1e6)
    panel = Panel(
        name=name,
        points=loop,
        edges=tuple(curves),
        rotation=Rotation.from_euler("xyz", angles, degrees=True).as_matrix().round(15) + 0.0,
        translation=np.array(
            get_vector(file.get("translation", [0, 0, 0]), 3, f"{where} translation", MAX_SIZE / scale)
        )
        * scale,
        label=get_text(file.get("label", ""), f"{where} label"),
    )
    known = ("vertices", "edges", "rotation", "translation", "label")
    rest = {"panel": {key: value for key, value in file.items() if key not in known}, "edges": rests}
    if panel_area(panel) < 0:
        panel = mirror_panel(panel)
    return panel, Numbering(tuple(order), tuple(starts)), rest


def _order_loop(ends: list[tuple[int, int]], name: str) -> tuple[list[int], list[bool]]:
    """Order edges into one loop from edge 0; True marks an edge that the file has in reverse. Raise `PanelOpen` where
    they are not exactly one closed loop."""
    at: dict[int, list[int]] = {}
    for number, pair in enumerate(ends):
        for end in set(pair):
            at.setdefault(end, []).append(number)
    if len(ends) < 2 or any(len(numbers) != 2 for numbers in at.values()) or any(a == b for a, b in ends):
        loose = [vertex for vertex, numbers in at.items() if len(numbers) != 2]
        places = [Place(name, edge=at[vertex][0], vertex=vertex) for vertex in loose] or [Place(name)]
        raise PanelOpen(f"the edges of panel '{name}' do not form one closed loop.", *places)
    order, flipped, tip = [0], [False], ends[0][1]
    while tip != ends[0][0]:
        number = next(n for n in at[tip] if n != order[-1])
        if number in order:
            break
        order.append(number)
        flipped.append(ends[number][0] != tip)
        tip = ends[number][0] if flipped[-1] else ends[number][1]
    if len(order) != len(ends):
        apart = next(number for number in range(len(ends)) if number not in order)
        raise PanelOpen(
            f"the edges of panel '{name}' form more than one loop; holes in a panel are not supported.",
            Place(name, edge=apart),
        )
    return order, flipped


def _read_edge(
    file: dict[str, Any], start: np.ndarray, end: np.ndarray, back: bool, scale: float, relative: bool, where: str
) -> Edge:
    label = get_text(file.get("label", ""), f"{where} label")
    curve = file.get("curvature")
    if curve is None:
        return Edge("line", label=label)
    if isinstance(curve, list):
        curve = {"type": "quadratic", "params": [curve]}
    curve = get_object(curve, f"{where} curvature")
    kind = curve.get("type")
    params = get_list(curve.get("params", []), f"{where} curvature params")
    if kind == "circle":
        edge = _read_circle(params, float(np.linalg.norm(end - start)), scale, where)
    elif kind in ("quadratic", "cubic"):
        if len(params) != (1 if kind == "quadratic" else 2):
            raise PatternValueBad(f"{where}: a {kind} curve has {1 if kind == 'quadratic' else 2} control points.")
        bound = 1e3 if relative else MAX_SIZE / scale
        handles = np.array([get_vector(param, 2, f"{where} control point", bound) for param in params])
        if not relative:
            along = end - start
            left = np.array([-along[1], along[0]])
            offset = handles * scale - start
            handles = np.stack([offset @ along, offset @ left], axis=-1) / (along @ along)
        edge = Edge(kind, handles)
    else:
        raise PatternValueBad(f"{where}: curvature type {str(kind)[:40]!r} is none of quadratic, cubic, circle.")
    edge = Edge(edge.kind, edge.handles, label)
    return reverse_edge(edge) if back else edge


def _read_circle(params: list[Any], length: float, scale: float, where: str) -> Edge:
    """Convert [radius, large_arc, right] to the apex's height over the chord (right of it: negative)."""
    if len(params) != 3:
        raise PatternValueBad(f"{where}: a circle has the parameters radius, large_arc, right.")
    radius = get_number(params[0], f"{where} radius", low=0.0, high=1e9) * scale / length
    large, right = (bool(get_number(flag, f"{where} circle flag", low=0.0, high=1.0)) for flag in params[1:])
    if radius < 0.5 * (1.0 - RADIUS_SLACK):
        raise PatternValueBad(f"{where}: the radius is shorter than half the distance of its endpoints.")
    drop = np.sqrt(max(radius * radius - 0.25, 0.0))
    # radius - drop cancels on flat arcs; 1/4 / (radius + drop) is the same number.
    height = radius + drop if large else 0.25 / (max(radius, 0.5) + drop)
    return Edge("arc", np.array([[0.5, -height if right else height]]))


def _read_seams(stitches: list[Any], numbers: dict[str, dict[int, int]]) -> tuple[Seam, ...]:
    seams, used = [], set()
    for number, stitch in enumerate(stitches):
        where = f"stitch {number}"
        sides = get_list(stitch, where)
        refs = []
        for side in sides[:2]:
            side = get_object(side, where)
            if "panel" not in side or "edge" not in side:
                raise PatternIncomplete(f"{where}: a side needs 'panel' and 'edge'.")
            panel = get_text(side["panel"], f"{where} panel")
            if panel not in numbers:
                message = f"{where} names the panel '{panel}', which the pattern does not have."
                raise SeamUnknown(message, Place(panel), seam=number)
            if (
                isinstance(side["edge"], bool)
                or not isinstance(side["edge"], int)
                or side["edge"] not in numbers[panel]
            ):
                raise SeamUnknown(
                    f"{where} names an edge that panel '{panel}' does not have.", Place(panel), seam=number
                )
            refs.append(EdgeRef(panel, numbers[panel][side["edge"]]))
        if len(refs) != 2:
            raise PatternIncomplete(f"{where} has fewer than two sides.", seam=number)
        for ref in refs:
            if ref in used:
                edge = next(old for old, new in numbers[ref.panel].items() if new == ref.edge)
                message = f"edge {edge} of panel '{ref.panel}' takes part in two stitches; split the edge."
                raise SeamTwice(message, Place(ref.panel, edge=edge), seam=number)
            used.add(ref)
        seams.append(Seam(refs[0], refs[1], reversed="right_wrong" not in [s for s in sides[2:] if isinstance(s, str)]))
    return tuple(seams)


def _restore_extensions(pattern: Pattern, extension: dict[str, Any]) -> tuple[Pattern, frozenset[str]]:
    """Restore grainlines, notches and contour names that `write_pattern` kept; invalid ones are ignored. Return also
    the names of the panels that have a grainline."""
    notes = extension.get("panels", {}) if isinstance(extension.get("panels", {}), dict) else {}
    panels, grained = [], []
    for panel in pattern.panels:
        note = notes.get(panel.name, {})
        note = note if isinstance(note, dict) else {}
        contours = note.get("contours", [])
        if (
            isinstance(contours, list)
            and len(contours) == len(panel.edges)
            and all(isinstance(c, str) for c in contours)
        ):
            edges = tuple(replace(edge, contour=name) for edge, name in zip(panel.edges, contours, strict=True))
            panel = replace(panel, edges=edges)
        grain = note.get("grainline")
        if isinstance(grain, int | float) and not isinstance(grain, bool) and abs(grain) <= 10.0:
            panel = replace(panel, grainline=float(grain))
            grained.append(panel.name)
        notches = []
        for notch in note.get("notches", []) if isinstance(note.get("notches", []), list) else []:
            if isinstance(notch, list) and len(notch) == 2 and all(isinstance(v, int | float) for v in notch):
                if 0 <= notch[0] < len(panel.edges) and 0.0 <= notch[1] <= 1.0:
                    notches.append((int(notch[0]), float(notch[1])))
        panels.append(replace(panel, notches=tuple(notches)))
    return replace(pattern, panels=tuple(panels)), frozenset(grained)


def _mark_gathers(pattern: Pattern, extension: dict[str, Any]) -> Pattern:
    """Mark gathered seams: as the file says if this program wrote it, else by their ratio of lengths."""
    said = extension.get("gathered")
    seams = []
    for index, seam in enumerate(pattern.seams):
        a, b = (edge_length(pattern.panel(ref.panel), ref.edge) for ref in (seam.a, seam.b))
        wide = abs(a / b - 1.0) > GATHER_TOLERANCE
        seams.append(replace(seam, gathered=index in said if isinstance(said, list) else wide))
    return replace(pattern, seams=tuple(seams))
