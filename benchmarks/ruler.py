"""What a ruler on the flat panels says of worn cloth: how much they lack of the body's girth, level by level."""

from __future__ import annotations

import numpy as np
from garmentq.core.body.girths import TapeMeasure
from garmentq.core.garment.curves import edge_length
from garmentq.core.reuse.wear.ease import unpose_points
from garmentq.core.reuse.wear.worn import WornGarment

HAND = (0.0, 0.02, 0.04, 0.06)
"""Distances from a place at which a tailor lays the tape anew [m]: down, at the hips up, along the arm out."""


def measure_lack(worn: WornGarment, place: str) -> float:
    """Return by how much the flat panels are shorter than the wearer's girth at a place [m]; negative: wider.

    A level crosses the edges of each panel; a ruler is laid in the flat from edge to edge, and the widths are added (of
    legs and sleeves the mean of both). The largest lack counts, at the chest that of the narrowest line.
    """
    tape, nodes = TapeMeasure.of(worn.body), unpose_points(worn.garment.nodes, worn.body)
    if place == "waist" and (waist := worn.garment.contour("waist")) is not None:
        height = float(nodes[waist.vertices, 1].mean())
        return float(tape.trunk(height).value) - _waist_edges(worn, waist.vertices)
    level = tape.measure(place).level
    signs = {"hip": 1.0, "upper_arm": 1.0, "chest": -1.0, "thigh": -1.0, "waist": 0.0}
    levels = sorted({level + signs[place] * far for far in HAND})
    widths = {at: _width(worn, nodes, tape, place, at) for at in levels}
    known = {at: width for at, width in widths.items() if width > 0.0}
    if not known:
        return float("nan")
    if place == "chest":
        return float(tape.measure(place).value) - min(known.values())
    girth = {"thigh": tape.thighs, "upper_arm": tape.arms}.get(place, tape.trunk)
    return max(float(girth(at).value) - width for at, width in known.items())


def _waist_edges(worn: WornGarment, waist: np.ndarray) -> float:
    """Return the length of the pattern's edges that lie along the waist's nodes [m]."""
    garment, panels = worn.garment, {panel.name: panel for panel in worn.pattern.panels}
    along = [ref for ref, uv in garment.edge_uv.items() if np.isin(garment.uv_node[uv], waist).all()]
    return sum(edge_length(panels[ref.panel], ref.edge) for ref in along)


def _width(worn: WornGarment, nodes: np.ndarray, tape: TapeMeasure, place: str, level: float) -> float:
    """Return the sum of the panels' widths at a level [m]; zero where there is no cloth, or only a part of a line."""
    garment, sleeves = worn.garment, place == "upper_arm"
    centre = float(tape.body.joint("pelvis")[0])
    heights = np.abs(nodes[:, 0] - centre) + centre if sleeves else nodes[:, 1]
    open_nodes = np.concatenate([contour.vertices for contour in garment.contours])
    labels = {panel.name: panel.label for panel in worn.pattern.panels}
    tops = [garment.uv_node[uv] for ref, uv in garment.edge_uv.items() if labels[ref.panel] == "sleeve"]
    sleeve_nodes = np.unique(np.concatenate(tops)) if tops and not sleeves else np.zeros(0, dtype=int)
    crossings: dict[str, list[np.ndarray]] = {}
    for ref, along in garment.edge_uv.items():
        at, flat = heights[garment.uv_node[along]], garment.uv[along]
        for n in np.flatnonzero((at[:-1] > level) != (at[1:] > level)):
            if np.isin(garment.uv_node[along], open_nodes).all():
                return 0.0
            if np.isin(garment.uv_node[along], sleeve_nodes).all():  # through an armhole
                return 0.0
            share = (level - at[n]) / (at[n + 1] - at[n])
            crossings.setdefault(ref.panel, []).append(flat[n] + share * (flat[n + 1] - flat[n]))
    total = 0.0
    for panel in worn.pattern.panels:
        if (panel.label == "sleeve") == sleeves:
            points = np.array(crossings.get(panel.name, np.zeros((0, 2))))
            if len(points) % 2:
                return 0.0  # the level ends within this panel: no line to lay a ruler along
            total += _join_nearest(points)
    return 0.5 * total if place in ("thigh", "upper_arm") else total


def _join_nearest(points: np.ndarray) -> float:
    """Return the least sum of lengths that join points in pairs [m], shape [n, 2], n even; 0 for none.

    A seam that bends to and fro across the level is crossed three times: a piece lies from it to itself.
    """
    if not len(points):
        return 0.0
    first, rest = points[0], points[1:]
    return min(
        float(np.linalg.norm(first - other)) + _join_nearest(np.delete(rest, n, axis=0)) for n, other in enumerate(rest)
    )
