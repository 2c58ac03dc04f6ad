"""The seams and edges of a sewn garment by what they are: shoulders, side seams, inseams, necklines, hems."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..curves import edge_length
from ..orientation import place_points
from ..panel_parts import find_arm_panels, find_side
from ..pattern import Pattern
from ..polygon import polygon_area
from ..seam_runs import SeamRun, end_of, length_of, list_runs, use_of
from .finished_points import Line, Measured
from .flatten import flatten_edge, flatten_outline

SLIT_GAP = 1e-3
"""Distance between both sides of a slit in their places up to which they lie on each other [m]."""

RunEnds = tuple[SeamRun, str, str]
"""A run, and the uses of those before and after it."""


class SewnLines:
    """Find the seams and edges of one pattern, whatever its author calls them.

    Attributes:
        pattern: The pattern.
        arms: Its panels on the arms, as `find_arm_panels`.
        body: The others.
        outlines: Outline of each panel as a polygon [m], shape [n, 2] each.
        runs: The runs of each panel.
        uses: What each run is, as `use_of`.
        shoulders: Seams from the neckline to the armhole.
        necks: Seams on the shoulders that begin at the neckline.
        legs: Seams that end at a leg's edge, with the uses at their ends.
        inseams, outseams: Seams of legs, inside and outside.
        hangs_from_waist: Whether it has a waist edge and no shoulders.
    """

    def __init__(self, pattern: Pattern) -> None:
        """Find them."""
        self.pattern = pattern
        self.arms = find_arm_panels(pattern)
        self.body = [panel for panel in pattern.panels if panel.name not in self.arms]
        self.outlines = {panel.name: flatten_outline(panel)[0] for panel in pattern.panels}
        self.runs = list_runs(pattern)
        self.uses = {run: use_of(pattern, run) for runs in self.runs.values() for run in runs}
        ends = [one for runs in self.runs.values() for one in self.list_ends(runs)]
        trunk = [one for one in ends if one[0].panel not in self.arms and self.uses[one[0]] == "seam"]
        self.shoulders = [run for run, before, after in trunk if {before, after} == {"neck", "armhole"}]
        self.necks = [run for run, before, after in trunk if "neck" in (before, after) and self._is_on_shoulder(run)]
        self.legs = [one for one in trunk if "leg" in one[1:]]
        self.outseams = [run for run, before, after in self.legs if {before, after} <= {"leg", "waist"}]
        self.inseams = self._inseams()
        self.hangs_from_waist = any(use == "waist" for use in self.uses.values()) and not self.shoulders

    def list_ends(self, runs: tuple[SeamRun, ...]) -> Iterator[RunEnds]:
        """Yield each run with the uses of those before and after it."""
        for i, run in enumerate(runs):
            yield run, self.uses[runs[i - 1]], self.uses[runs[(i + 1) % len(runs)]]

    def _inseams(self) -> list[SeamRun]:
        """Return the runs from a leg's edge to the crotch: of those of a panel the one nearer to the middle."""
        found = []
        for name in {run.panel for run, _, _ in self.legs}:
            own = [run for run, _, _ in self.legs if run.panel == name and run not in self.outseams]
            other = [run for run, _, _ in self.legs if run.panel == name]
            if own and len(other) > 1:
                found.append(min(own, key=lambda run: abs(self.place(run).mean(axis=0)[0])))
        return sorted(found, key=lambda run: run.panel)

    def _is_on_shoulder(self, run: SeamRun) -> bool:
        """Check whether a seam from the neckline joins front and back, more across than down."""
        sides = {find_side(self.pattern.panel(name)) for name in (run.panel, run.partner)}
        across, down, _ = np.abs(np.diff(self.place(run), axis=0)[0])
        return len(sides) > 1 and bool(across > down)

    def place(self, run: SeamRun) -> np.ndarray:
        """Return the places of both ends of a run [m], shape [2, 3]."""
        panel = self.pattern.panel(run.panel)
        return place_points(panel, np.stack([end_of(self.pattern, run, False), end_of(self.pattern, run, True)]))

    def line(self, run: SeamRun) -> Line:
        """Return the polyline of a run."""
        panel = self.pattern.panel(run.panel)
        return run.panel, np.concatenate([flatten_edge(panel, i) for i in run.edges])

    def mean(self, runs: list[SeamRun]) -> Measured | None:
        """Return the mean length of runs, one of each seam."""
        if not runs:
            return None
        return float(np.mean([length_of(self.pattern, run) for run in runs])), tuple(map(self.line, runs))

    def around(self, contour: str, is_halved: bool = False) -> Measured | None:
        """Return the length of a contour, or the mean of its two sides."""
        runs = [run for run in self.uses if run.contour == contour and not run.partner]
        if not runs:
            return None
        sides = {
            self.pattern.panel(run.panel).edges[run.edges[0]].contour for run in runs
        } if is_halved else {contour}  # fmt: skip
        total = sum(length_of(self.pattern, run) for run in runs)
        return total / len(sides), tuple(map(self.line, runs))

    def neck(self) -> Measured | None:
        """Return the length of the neckline: of its seam with a collar, else of its edge."""
        seam = [run for run, use in self.uses.items() if use == "neck" and run.partner]
        if seam:
            return sum(length_of(self.pattern, run) for run in seam), tuple(map(self.line, seam))
        is_wrapped = any(run.contour == "wrap" for run in self.uses)  # then its edges cross, and end at no point
        found = self.around("neck") if (self.necks or self.arms) and not is_wrapped else None
        return None if found is None else (found[0] - self._slit_length("neck"), found[1])

    def _slit_length(self, contour: str) -> float:
        """Return the length of the edges of a contour that lie on another one of it, both sides of a slit [m]."""
        edges = [
            (panel, i, place_points(panel, panel.points[[i, (i + 1) % len(panel.points)]]))
            for panel in self.pattern.panels for i, edge in enumerate(panel.edges) if edge.contour == contour
        ]  # fmt: skip
        return sum(
            edge_length(panel, i) for panel, i, ends in edges
            if any(np.abs(ends - other[::-1]).max() < SLIT_GAP for *_, other in edges)
        )  # fmt: skip

    def band_width(self, contour: str) -> float:
        """Return the width of the band that has a contour [m], or 0 where the contour is on the cloth itself."""
        for run, use in self.uses.items():
            if use == contour and not run.partner:
                panel = self.pattern.panel(run.panel)
                is_band = self.arms.get(run.panel, 0) > 1 if contour == "cuff" else panel.label in ("waistband", "band")
                if is_band:
                    return abs(polygon_area(self.outlines[run.panel])) / length_of(self.pattern, run)
        return 0.0
