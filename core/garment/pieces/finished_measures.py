"""Finished measures of a garment at the points where the trade takes them, flat, in its pattern."""

from __future__ import annotations

import numpy as np

from ..orientation import place_points
from ..outline import PLACKET_CONTOUR
from ..panel_parts import Side, find_part, find_side
from ..pattern import Panel, Pattern
from ..seam_runs import NECK_PARTS, SeamRun, end_of
from .finished_points import FinishedMeasure, FinishedPoint, Line, Measured
from .panel_cuts import cut_level, cut_upright
from .sewn_lines import SewnLines
from .sleeve_measures import BELOW_ARMHOLE, measure_bicep, measure_sleeve

BELOW_FORK = 0.025
"""Distance of the thigh below the crotch [m]: an inch, as size specifications have it."""

ABOVE_FORK = 0.075
"""Distance of the hip of trousers above the crotch [m]: three inches, as size specifications have it."""

BELOW_WAIST = 0.20
"""Distance of the hip of skirts and dresses below the waist [m], as size specifications have it."""

FINISHED_LEVEL_SPACING = 0.005
"""Distance of the levels among which the narrowest is sought [m]: half of what a tape is read to."""


WAIST_DROPS = (0.10, 0.22, 0.32)
"""Least, usual and largest drop from the armhole to the waist [m]: of the drafts 22 cm; children's to long-waisted."""

BESIDE_MIDDLE = 0.005
"""Distance from the middle at which the length of a skirt is taken [m]: the middle itself may be a seam."""


def measure_finished(pattern: Pattern) -> tuple[FinishedMeasure, ...]:
    """Measure a garment at all points of the trade that it has, in the order of `FinishedPoint`.

    Girths are sums of level chords of the placed panels, without what darts take in; sleeves are measured square to
    their upper seam; of two sides the mean is given.

    Args:
        pattern: Its open edges named by contours.
    """
    taken = _Taken(pattern)
    found = {
        FinishedPoint.CHEST: taken.chest(),
        FinishedPoint.WAIST: taken.waist(),
        FinishedPoint.HIP: taken.hip(),
        FinishedPoint.HEM: taken.around("hem") or taken.around("leg", True),
        FinishedPoint.LENGTH: taken.length(),
        FinishedPoint.SHOULDER: taken.mean(taken.shoulders),
        FinishedPoint.SLEEVE: measure_sleeve(taken),
        FinishedPoint.BICEP: measure_bicep(taken),
        FinishedPoint.CUFF: taken.around("cuff", True),
        FinishedPoint.NECK: taken.neck(),
        FinishedPoint.RISE: taken.rise(),
        FinishedPoint.THIGH: taken.thigh(),
        FinishedPoint.INSEAM: taken.mean(taken.inseams),
        FinishedPoint.OUTSEAM: taken.outseam(),
    }
    return tuple(
        FinishedMeasure(point, one[0], one[1]) for point, one in found.items() if one is not None and one[0] > 0.0
    )


class _Taken(SewnLines):
    """Measure one pattern; each method returns a value [m] and its lines, or None where the garment has no such."""

    def girth(self, heights: dict[str, float]) -> Measured | None:
        """Return the way round the panels at heights [m] in their places, one for each panel's name."""
        chords = [
            (panel, one)
            for panel in self.body
            if panel.name in heights
            for one in cut_level(panel, self.outlines[panel.name], heights[panel.name])
        ]
        if not chords:
            return None
        total = sum(float(np.linalg.norm(one[1] - one[0])) for _, one in chords)
        return total - self._overlap(chords), tuple((panel.name, one) for panel, one in chords)

    def _overlap(self, chords: list[tuple[Panel, np.ndarray]]) -> float:
        """Return how far fronts lie over each other along chords [m], of a wrap or a placket; else 0."""
        contours = {run.contour for run in self.uses}
        if not contours & {"wrap", PLACKET_CONTOUR}:
            return 0.0
        front = [place_points(panel, one)[:, 0] for panel, one in chords if find_side(panel) is Side.FRONT]
        spans = sorted((float(x.min()), float(x.max())) for x in front)
        covered, reach = 0.0, -np.inf
        for low, high in spans:
            covered += max(0.0, high - max(low, reach))
            reach = max(reach, high)
        return sum(high - low for low, high in spans) - covered

    def _underarms(self) -> dict[str, float]:
        """Return the height of the lowest point of the armhole of each panel that has one [m]."""
        found: dict[str, float] = {}
        for run, use in self.uses.items():
            if use == "armhole" and run.panel not in self.arms:
                low = float(self.place(run)[:, 1].min())
                found[run.panel] = min(low, found.get(run.panel, np.inf))
        return found

    def _levels(self, drop: float) -> dict[str, float]:
        """Return a height of each panel of the trunk below the armholes by a drop [m]: its own armhole's, or of panels
        without one, the mean of those on its side."""
        own = self._underarms()
        if not own:
            return {}
        sides = {panel.name: find_side(panel) for panel in self.body}
        levels = {}
        for panel in self.body:
            known = [level for name, level in own.items() if sides[name] == sides[panel.name]] or list(own.values())
            levels[panel.name] = own.get(panel.name, float(np.mean(known))) - drop
        return levels

    def chest(self) -> Measured | None:
        """Return the girth below the armholes."""
        return self.girth(self._levels(BELOW_ARMHOLE))

    def waist(self) -> Measured | None:
        """Return the waist edge, or the narrowest girth below the chest."""
        if (edge := self.around("waist")) is not None:
            return edge
        found = self._narrowest()
        return None if found is None else found[1]

    def _narrowest(self) -> tuple[float, Measured] | None:
        """Return the drop below the armholes at which the girth is least [m], and the girth there: among `WAIST_DROPS`,
        above crotch and hem."""
        own = self._underarms()
        if not own:
            return None
        deepest = min(own.values()) - max(self._fork(), self._lower_edge()) - FINISHED_LEVEL_SPACING
        first, usual, last = WAIST_DROPS
        drops = np.arange(min(first, deepest), min(last, deepest) + 1e-9, FINISHED_LEVEL_SPACING)
        found = [(float(drop), one) for drop in drops if (one := self.girth(self._levels(float(drop)))) is not None]
        return min(found, key=lambda one: (round(one[1][0], 4), abs(one[0] - usual)), default=None)

    def _fork(self) -> float:
        """Return the height of the crotch [m], or minus infinity."""
        return max((float(self.place(run)[:, 1].max()) for run in self.inseams), default=-np.inf)

    def _lower_edge(self) -> float:
        """Return the height of the highest point of the hem [m], or of the lowest point of all."""
        ends = [self.place(run)[:, 1].max() for run, use in self.uses.items() if use == "hem"]
        return float(max(ends, default=min(place_points(one, one.points)[:, 1].min() for one in self.body)))

    def hip(self) -> Measured | None:
        """Return the girth at the hips, where the garment reaches them."""
        if self.inseams and self.hangs_from_waist:
            return self._level_girth(self._fork() + ABOVE_FORK)
        if self.hangs_from_waist:
            tops = [self.place(run)[:, 1].max() for run, use in self.uses.items() if use == "waist"]
            return self._level_girth(float(max(tops)) - BELOW_WAIST)
        narrowest = self._narrowest()
        if narrowest is None:
            return None
        level = float(np.mean(list(self._underarms().values()))) - narrowest[0] - BELOW_WAIST
        return self._level_girth(level)

    def _level_girth(self, level: float) -> Measured | None:
        """Return the girth at one height [m], where all of the garment is above its hem and its crotch."""
        if level <= max(self._fork(), self._lower_edge()) + 1e-9:
            return None
        return self.girth({panel.name: level for panel in self.body})

    def length(self) -> Measured | None:
        """Return the length at the back from the side neck point, or of skirts from the middle of the waist."""
        starts: list[tuple[float, float]] = []
        for run in self.necks:
            if find_side(self.pattern.panel(run.panel)) is Side.BACK:
                ends = self.place(run)
                starts.append((float(ends[np.abs(ends[:, 0]).argmin(), 0]), float(ends[:, 1].max())))
        if self.hangs_from_waist and not self.inseams:
            starts = [(BESIDE_MIDDLE, np.inf)]
        back = [one for one in self.body if find_side(one) is Side.BACK and find_part(one) not in NECK_PARTS]
        columns = [
            [line for panel in back for line in cut_upright(panel, self.outlines[panel.name], x, top)]
            for x, top in starts
        ]
        known = [self._outer(one) for one in columns if one]
        if not known:
            return None
        return float(np.mean([self._height(one) for one in known])), tuple(line for one in known for line in one)

    def _outer(self, lines: list[Line]) -> list[Line]:
        """Return upright lines without those beside longer ones, such as where a crotch reaches over the middle."""
        spans = [tuple(place_points(self.pattern.panel(name), one)[::-1, 1]) for name, one in lines]
        return [
            line for i, line in enumerate(lines)
            if not any(low <= spans[i][0] and spans[i][1] <= high and j != i for j, (low, high) in enumerate(spans))
        ]  # fmt: skip

    def _height(self, lines: list[Line]) -> float:
        """Return the height that upright lines cover together in their places [m]."""
        covered, reach = 0.0, -np.inf
        for low, high in sorted(tuple(place_points(self.pattern.panel(name), one)[::-1, 1]) for name, one in lines):
            covered += max(0.0, high - max(low, reach))
            reach = max(reach, high)
        return covered

    def rise(self) -> Measured | None:
        """Return the length of the front crotch seam, with the waistband."""
        if not self.hangs_from_waist:
            return None
        ends = [one for runs in self.runs.values() for one in self.list_ends(runs)]
        found = [
            run for run, before, after in ends
            if self.uses[run] == "seam" and {before, after} == {"waist", "seam"} and run not in self.outseams
            and find_side(self.pattern.panel(run.panel)) is Side.FRONT and self._touches_inseam(run)
        ]  # fmt: skip
        one = self.mean(found)
        return None if one is None else (one[0] + self.band_width("waist"), one[1])

    def _touches_inseam(self, run: SeamRun) -> bool:
        ends = [
            end_of(self.pattern, one, last) for one in self.inseams if one.panel == run.panel for last in (False, True)
        ]
        own = [end_of(self.pattern, run, last) for last in (False, True)]
        return any(np.allclose(one, other, atol=1e-9) for one in ends for other in own)

    def thigh(self) -> Measured | None:
        """Return the girth of one leg below the crotch."""
        if not self.inseams:
            return None
        levels = {run.panel: float(self.place(run)[:, 1].max()) - BELOW_FORK for run in self.inseams}
        low = min(levels.values())
        names = {one.name for one in self.body if one.name in levels or find_side(one) is Side.BESIDE}
        found = self.girth({name: levels.get(name, low) for name in names})
        return None if found is None else (found[0] / 2.0, found[1])

    def outseam(self) -> Measured | None:
        """Return the length of the side seams of trousers, with the waistband."""
        found = self.mean(self.outseams)
        return None if found is None else (found[0] + self.band_width("waist"), found[1])
