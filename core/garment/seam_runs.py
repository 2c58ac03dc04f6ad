"""The runs of a panel's outline: neighbouring edges that are sewn to one panel, or open with one contour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .curves import edge_length
from .panel_parts import find_arm_panels, find_part
from .pattern import EdgeRef, Pattern

NECK_PARTS = ("collar", "hood")
"""Parts of a garment that are sewn to the neckline."""

BAND_PARTS = ("band", "wb")
"""Parts of a garment that finish an edge."""


@dataclass(frozen=True)
class SeamRun:
    """Describe neighbouring edges of a panel that have one use.

    Attributes:
        panel: Name of the panel.
        edges: Their numbers, in the outline's order.
        partner: Name of the panel that they are sewn to, or an empty text.
        contour: Name of their contour, without its side, or an empty text.
    """

    panel: str
    edges: tuple[int, ...]
    partner: str
    contour: str


def list_runs(pattern: Pattern) -> dict[str, tuple[SeamRun, ...]]:
    """Return the runs of each panel, in the order of its outline."""
    partners = {}
    for seam in pattern.seams:
        partners[seam.a], partners[seam.b] = seam.b.panel, seam.a.panel
    found = {}
    for panel in pattern.panels:
        uses = [
            (partners.get(EdgeRef(panel.name, i), ""), edge.contour.split(".")[0]) for i, edge in enumerate(panel.edges)
        ]
        count = len(uses)
        first = next((i for i in range(count) if uses[i] != uses[i - 1]), 0)
        runs: list[SeamRun] = []
        for i in [*range(first, count), *range(first)]:
            if runs and uses[i] == (runs[-1].partner, runs[-1].contour):
                runs[-1] = SeamRun(panel.name, (*runs[-1].edges, i), *uses[i])
            else:
                runs.append(SeamRun(panel.name, (i,), *uses[i]))
        found[panel.name] = tuple(runs)
    return found


def length_of(pattern: Pattern, run: SeamRun) -> float:
    """Return the length of a run [m]."""
    panel = pattern.panel(run.panel)
    return sum(edge_length(panel, i) for i in run.edges)


def end_of(pattern: Pattern, run: SeamRun, last: bool) -> np.ndarray:
    """Return the point at which a run begins or ends [m], shape [2]."""
    points = pattern.panel(run.panel).points
    return np.asarray(points[(run.edges[-1] + 1) % len(points)] if last else points[run.edges[0]])


def use_of(pattern: Pattern, run: SeamRun) -> str:
    """Return what a run is: its contour, `neck`, `armhole` or `waist` where it is sewn to what finishes these, `cuff`
    where it is sewn to a sleeve's band, `seam` for others, or an empty text for an open edge without a name."""
    arms = find_arm_panels(pattern)
    if not run.partner:
        return run.contour
    own, other = arms.get(run.panel, 0), arms.get(run.partner, 0)
    part = find_part(pattern.panel(run.partner))
    if part in NECK_PARTS and find_part(pattern.panel(run.panel)) not in NECK_PARTS:
        return "neck"
    if other and not own:
        return "armhole"
    if own and not other:
        return "cap"
    if own and other > own:
        return "cuff"
    if not own and part in BAND_PARTS and find_part(pattern.panel(run.panel)) not in BAND_PARTS:
        return next((one for one in _contours(pattern, run.partner) if one), "seam")
    return "seam"


def _contours(pattern: Pattern, name: str) -> list[str]:
    return sorted({edge.contour.split(".")[0] for edge in pattern.panel(name).edges})
