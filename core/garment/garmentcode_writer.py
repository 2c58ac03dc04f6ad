"""Write the pattern JSON of GarmentCode; the format is described in `garmentcode`."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .curves import is_flat_arc, unit_circle
from .grain import list_unknown_grains
from .orientation import mirror_panel
from .pattern import Panel, Pattern

EXTENSION_KEY = "garmentq"
"""Key under `properties` for what the format has no place for."""


LENGTH_DECIMAL_COUNT = 12
"""Number of decimals of a length in metres that are written: 1e-12 m is far above the rounding of units and far below
every significant length, so that reading and writing again gives the same digits."""

RADIUS_DIGIT_COUNT = 13
"""Number of significant digits of a radius that are written, for the same reason. An angle in degrees has six fewer, as
decimals."""


def write_pattern(pattern: Pattern) -> dict[str, Any]:
    """Return a pattern as a GarmentCode object, ready for `json.dump`; unknown keys of its file are kept. Reading and
    writing it again gives the same digits."""
    extra = pattern.extra
    per_metre = float(extra.get("units_in_meter", 100))
    rests = extra.get("panels", {})
    panels = {}
    for panel in pattern.panels:
        panels[panel.name] = _write_panel(panel, per_metre, rests.get(panel.name, {}))
    stitches = [
        [{"panel": ref.panel, "edge": ref.edge} for ref in (seam.a, seam.b)]
        + ([] if seam.reversed else ["right_wrong"])
        for seam in pattern.seams
    ]
    unknown = list_unknown_grains(pattern)
    extension = {
        "category": pattern.category,
        "gathered": [index for index, seam in enumerate(pattern.seams) if seam.gathered],
        "panels": {
            panel.name: {
                **({} if panel.name in unknown else {"grainline": panel.grainline}),
                "notches": [list(notch) for notch in panel.notches],
                "contours": [edge.contour for edge in panel.edges],
            }
            for panel in pattern.panels
        },
    }
    properties = {
        "curvature_coords": "relative",
        "normalize_panel_translation": False,
        "normalized_edge_loops": True,
        **extra.get("properties", {}),
        "units_in_meter": extra.get("units_in_meter", 100),
        EXTENSION_KEY: extension,
    }
    properties["curvature_coords"] = "relative"
    body = {"panels": panels, "stitches": stitches, **extra.get("pattern", {})}
    body.setdefault("panel_order", [panel.name for panel in pattern.panels])
    return {"pattern": body, "parameters": {}, "parameter_order": [], **extra.get("top", {}), "properties": properties}


def save_pattern(pattern: Pattern, path: str | Path) -> Path:
    """Write a pattern file and return its path."""
    path = Path(path)
    path.write_text(json.dumps(write_pattern(pattern), indent=1), encoding="utf-8")
    return path


def _write_panel(panel: Panel, per_metre: float, rest: dict[str, Any]) -> dict[str, Any]:
    drawn = mirror_panel(panel) if panel.mirrored else panel
    count = len(drawn.points)
    edges = []
    for index, edge in enumerate(drawn.edges):
        out: dict[str, Any] = {"endpoints": [index, (index + 1) % count]}
        if edge.kind in ("quadratic", "cubic"):
            out["curvature"] = {"type": edge.kind, "params": edge.handles.tolist()}
        elif edge.kind == "arc" and not is_flat_arc(edge):
            _, radius, _, _ = unit_circle(edge)
            length = float(np.linalg.norm(drawn.points[(index + 1) % count] - drawn.points[index]))
            height = edge.handles[0, 1]
            out["curvature"] = {
                "type": "circle",
                "params": [
                    float(f"{radius * length * per_metre:.{RADIUS_DIGIT_COUNT}g}"),
                    int(abs(height) > 0.5),
                    int(height < 0),
                ],
            }
        if edge.label:
            out["label"] = edge.label
        edges.append({**out, **rest.get("edges", {}).get(str(index), {})})
    return {
        "translation": _round_lengths(drawn.translation * per_metre, per_metre),
        "rotation": _euler_degrees(drawn.rotation),
        "vertices": _round_lengths(drawn.points * per_metre, per_metre),
        "edges": edges,
        **({"label": panel.label} if panel.label else {}),
        **rest.get("panel", {}),
    }


def _euler_degrees(rotation: np.ndarray) -> list[float]:
    with warnings.catch_warnings():
        # At 90 degrees about y two angles are not unique; scipy warns and takes a valid pair.
        warnings.simplefilter("ignore")
        angles = Rotation.from_matrix(rotation).as_euler("xyz", degrees=True)
    # near 90 degrees an arc sine loses half of the digits
    found: list[float] = (angles.round(RADIUS_DIGIT_COUNT - 6) + 0.0).tolist()
    return found


def _round_lengths(values: np.ndarray, per_metre: float) -> list[Any]:
    """Return lengths in a file's unit, rounded to the resolution."""
    found: list[Any] = (values.round(LENGTH_DECIMAL_COUNT - round(np.log10(per_metre))) + 0.0).tolist()
    return found
