"""Length and girth of finished sleeves."""

from __future__ import annotations

import numpy as np

from ..seam_runs import SeamRun, end_of
from .finished_points import Line, Measured
from .flatten import flatten_edge
from .panel_cuts import chord_through, walk_along
from .sewn_lines import RunEnds, SewnLines

BELOW_ARMHOLE = 0.025
"""Distance of chest and bicep below the armhole [m]: an inch, as size specifications have it."""


def _arm_runs(sewn: SewnLines) -> list[RunEnds]:
    return [
        one for name in sewn.arms for one in sewn.list_ends(sewn.runs[name])
        if sewn.uses[one[0]] == "seam" and {"cap", "cuff"} == set(one[1:])
    ]  # fmt: skip


def _upper_runs(sewn: SewnLines) -> list[SeamRun]:
    """Return the seams along the top of the sleeves: of those from cap to cuff in a panel the higher one, where the
    panel is a half."""
    found = []
    for name in sewn.arms:
        own = [run for run, _, _ in _arm_runs(sewn) if run.panel == name]
        if len(own) == 2 and own[0].partner != name:
            found.append(max(own, key=lambda run: float(sewn.place(run)[:, 1].mean())))
    return found


def measure_sleeve(sewn: SewnLines) -> Measured | None:
    """Return the length of the sleeves, with their bands."""
    halves = _upper_runs(sewn)
    if halves:
        found = sewn.mean(halves)
        return None if found is None else (found[0] + sewn.band_width("cuff"), found[1])
    whole = [one for name, depth in sewn.arms.items() if depth == 1 for one in _whole_sleeve(sewn, name)]
    if not whole:
        return None
    value = float(np.mean([np.linalg.norm(one[1] - one[0]) for _, one in whole]))
    return value + sewn.band_width("cuff"), tuple(whole)


def _whole_sleeve(sewn: SewnLines, name: str) -> list[Line]:
    """Return the line from the top of the cap of a sleeve in one panel to its lower edge, along the middle."""
    caps = [run for run in sewn.runs[name] if sewn.uses[run] == "cap"]
    cuffs = [run for run in sewn.runs[name] if sewn.uses[run] == "cuff"]
    if len(caps) < 2 or not cuffs:
        return []
    joints = [end_of(sewn.pattern, run, True) for run in caps]
    starts = [end_of(sewn.pattern, run, False) for run in caps]
    top = next((one for one in joints for other in starts if np.allclose(one, other, atol=1e-9)), None)
    if top is None:
        return []
    low = np.concatenate([sewn.line(run)[1] for run in cuffs])
    return [(name, np.stack([top, (low[0] + low[-1]) / 2.0]))]


def measure_bicep(sewn: SewnLines) -> Measured | None:
    """Return the girth of the sleeves below the armhole, square to their middle."""
    uppers = {run.panel: run for run in _upper_runs(sewn)}
    lines: list[Line] = []
    count = 0
    for name, depth in sewn.arms.items():
        if depth > 1:
            continue
        under = [run for run, _, _ in _arm_runs(sewn) if run.panel == name and run is not uppers.get(name)]
        if not under:
            return None
        if name in uppers:
            axis = end_of(sewn.pattern, uppers[name], True) - end_of(sewn.pattern, uppers[name], False)
            count += 1
        else:
            whole = _whole_sleeve(sewn, name)
            if not whole:
                return None
            axis = whole[0][1][1] - whole[0][1][0]
            count += 2
        panel = sewn.pattern.panel(name)
        points = np.concatenate([flatten_edge(panel, i) for i in under[0].edges])
        caps = [end_of(sewn.pattern, run, last) for run in sewn.runs[name] if sewn.uses[run] == "cap"
                for last in (False, True)]  # fmt: skip
        is_end = min(np.linalg.norm(points[-1] - one) for one in caps) < 1e-9
        at = walk_along(points[::-1] if is_end else points, BELOW_ARMHOLE)
        chord = chord_through(sewn.outlines[name], at, axis / np.linalg.norm(axis))
        if chord is None:
            return None
        lines.append((name, chord))
    total = sum(float(np.linalg.norm(one[1] - one[0])) for _, one in lines)
    return (2.0 * total / count, tuple(lines)) if count else None
