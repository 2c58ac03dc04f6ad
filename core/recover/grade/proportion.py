"""Define what grading keeps of a base pattern without evidence in the scan: proportions and directions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...garment.curves import edge_length, panel_area
from ...garment.handles import area_rates, handles_of, length_rates
from ...garment.pattern import EdgeRef, Pattern
from .compared_area import ComparedArea, area_rates_by_points
from .flattening import MIN_GRADED_EDGE_LENGTH, kept_vectors
from .parts import are_mirrored, count_seams, edges_until, find_armhole_pairs


@dataclass(frozen=True)
class ProportionSettings:
    """Describe which panels and edges are compared, and how closely grading keeps their ratios.

    Attributes:
        sister_area: Smallest ratio of areas of panels that belong together; backs are up to 1.5 times their fronts.
        compared_area: Smallest share of a panel's area that is compared: two sewn discs have 0, 60 patterns over 0.55.
        unlike_length: Ratio of lengths from which the open contours of two sisters are cut in different lines: a V
            neckline has twice the length of the back neckline, a crew neck 1.5 times.
        area_std: Standard deviation of ln of a ratio of areas [1]; authors who graded twofold kept it within 2.5 %.
        length_std: The same for lengths of two edges in one place of sister panels [1]; within 5 % there.
        notch_std: The same for lengths of two consecutive edges of one seam [1]: the cloth does not show where along a
            smooth seam the point between them is. A dress and shorts graded by their authors' program keep it within
            0.3, 0.2 in the root mean square: the hip stays, the hem moves down.
        width_std: The same for a bodice's width across the shoulders by that across the chest, from armhole to armhole
            [1]: eight garments of three makers keep it within 8 %, 3.5 % in the root mean square. On a smooth shoulder
            nothing else shows where the armhole crosses it.
        thread_angle: Largest angle between an edge and a thread, warp or weft, that counts as drawn along it [rad].
        thread_std: Standard deviation of that angle [rad].
        direction_std: Standard deviation of the direction of any other edge [rad]: armholes, caps and crotches turn by
            up to 3 degrees and grow by up to half: grading changes lengths more than directions.
        direction: Weight of a direction's standard deviation relative to a ratio's: enough where the cloth gives no
            evidence, a tenth of its evidence on a flared side. 0.03 left armholes 10 mm off, 0.3 changed no more.
    """

    sister_area: float = 0.6
    compared_area: float = 0.5
    unlike_length: float = 1.7
    area_std: float = 0.03
    length_std: float = 0.05
    notch_std: float = 0.2
    width_std: float = 0.04
    thread_angle: float = float(np.radians(1.0))
    thread_std: float = float(np.radians(1.0))
    direction_std: float = float(np.radians(3.0))
    direction: float = 0.1


@dataclass(frozen=True)
class Proportions:
    """Describe what grading a garment keeps.

    Attributes:
        settings: How closely it is kept.
        sisters: Compared areas, if large enough, of two like panels sewn along two seams or more.
        areas: ln of the compared area of the first by that of the second, shape [sister_count].
        edges: Edges in the same place of two sisters, neither sewn to the other.
        lengths: ln of the length of the first by that of the second, shape [edge_pair_count].
        notched: Consecutive edges of one seam between two panels.
        notches: ln of the length of the first by that of the second, shape [notch_count].
        widths: Two pairs of points each: across a panel at both ends of its armholes (`find_armhole_pairs`); across two
            sisters at the same place of their seams, and at an open contour that is far longer on the one.
        width_ratios: ln of the first distance by the second, shape [width_pair_count].
        vectors: Vectors along short edges and across darts (`kept_vectors`), shape [k, 2 point_count].
        drawn: Those of the base pattern, in standard deviations, shape [k].
        directed: Longer edges whose direction is kept: all but the seams between sisters, whose taper makes the girth.
        across: Unit vector across the chord of each, shape [directed_count, 2].
        spread: Standard deviation of its direction [rad], shape [directed_count].
    """

    settings: ProportionSettings
    sisters: tuple[tuple[ComparedArea, ComparedArea], ...]
    areas: np.ndarray
    edges: tuple[tuple[EdgeRef, EdgeRef], ...]
    lengths: np.ndarray
    notched: tuple[tuple[EdgeRef, EdgeRef], ...]
    notches: np.ndarray
    widths: tuple[tuple[tuple[int, int], tuple[int, int]], ...]
    width_ratios: np.ndarray
    vectors: np.ndarray
    drawn: np.ndarray
    directed: tuple[EdgeRef, ...]
    across: np.ndarray
    spread: np.ndarray

    def linearise(self, pattern: Pattern) -> tuple[np.ndarray, np.ndarray]:
        """Return the deviation from each rule, shape [rule_count], and its rates, shape [rule_count, 2 point_count].

        Both in standard deviations of a ratio; curves follow their chords. An edge far off its direction is taken to be
        cut otherwise, by a Cauchy weight: d sum ln(1 + (angle / s)^2), s its `spread`, d `direction`.
        """
        missing, rates, points, settings = [], [], pattern.points, self.settings
        for (a, b), ratio in zip(self.sisters, self.areas, strict=True):
            now, by = a.measure(pattern), b.measure(pattern)
            missing.append((ratio - np.log(now / by)) / settings.area_std)
            rates.append((a.rates(pattern) / now - b.rates(pattern) / by) / settings.area_std)
        for (edge, sister), ratio in zip(self.edges, self.lengths, strict=True):
            now = np.log(_length(pattern, edge) / _length(pattern, sister))
            missing.append((ratio - now) / settings.length_std)
            rates.append((_length_rate(pattern, edge) - _length_rate(pattern, sister)) / settings.length_std)
        for (one, other), ratio in zip(self.widths, self.width_ratios, strict=True):
            now, rate = _ln_distance(pattern, one)
            by, by_rate = _ln_distance(pattern, other)
            missing.append((ratio - (now - by)) / settings.width_std)
            rates.append((rate - by_rate) / settings.width_std)
        for (edge, after), ratio in zip(self.notched, self.notches, strict=True):
            now = np.log(_length(pattern, edge) / _length(pattern, after))
            missing.append((ratio - now) / settings.notch_std)
            rates.append((_length_rate(pattern, edge) - _length_rate(pattern, after)) / settings.notch_std)
        for ref, across, spread in zip(self.directed, self.across, self.spread, strict=True):
            start, end = pattern.ends_of(ref)
            chord = points[end] - points[start]
            scaled = across / float(np.linalg.norm(chord)) / spread
            angle = float(scaled @ chord)
            trust = np.sqrt(settings.direction / (1.0 + angle**2))
            row = np.zeros((len(pattern.points), 2))
            row[end], row[start] = trust * scaled, -trust * scaled
            missing.append(-trust * angle)
            rates.append(row)
        missing += list(self.drawn - self.vectors @ points.ravel())
        others = np.array([rate.ravel() for rate in rates]).reshape(-1, 2 * len(pattern.points))
        return np.array(missing), np.concatenate([others, self.vectors])

    def curve_rates(self, pattern: Pattern) -> np.ndarray:
        """Return the rates of `linearise`'s rules by all curves' handles, shape [rule_count, 2 handle_count]."""
        size = 2 * len(handles_of(pattern))

        def ratios(pairs: tuple[tuple[EdgeRef, EdgeRef], ...], spread: float) -> np.ndarray:
            found = [length_rates(pattern, {a: 1 / _length(pattern, a), b: -1 / _length(pattern, b)}) for a, b in pairs]
            return np.array(found).reshape(-1, size) / spread

        areas = []
        for a, b in self.sisters:
            now, by = 1 / a.measure(pattern), -1 / b.measure(pattern)
            areas.append(area_rates(pattern, {**dict.fromkeys(a.curves(), now), **dict.fromkeys(b.curves(), by)}))
        return np.concatenate(
            [
                np.array(areas).reshape(-1, size) / self.settings.area_std,
                ratios(self.edges, self.settings.length_std),
                np.zeros((len(self.widths), size)),
                ratios(self.notched, self.settings.notch_std),
                np.zeros((len(self.directed) + len(self.drawn), size)),
            ]
        )


def find_proportions(base: Pattern, settings: ProportionSettings = ProportionSettings()) -> Proportions:
    """Find the panels of a base pattern that are cut in proportion, and the directions of their edges.

    Front and back are sewn along two seams or more and are alike in area. Where a smooth surface hides the seam between
    them the scan does not show how the girth is divided; grading keeps the base pattern's division. Nor does cloth show
    a slightly slanted hem, or the place of an armhole that fits its sleeve's cap: their directions stay.
    """
    seams = count_seams(base)
    sisters, edges = [], []
    for (first, second), count in sorted(seams.items()):
        ratio = panel_area(base.panel(first)) / panel_area(base.panel(second))
        if count >= 2 and settings.sister_area < ratio < 1.0 / settings.sister_area:
            sisters.append((first, second))
            edges += _match_sister_edges(base, first, second)
    pairs = [(ComparedArea.of(base, first), ComparedArea.of(base, second)) for first, second in sisters]
    compared = tuple(
        pair
        for pair in pairs
        if all(one.measure(base) >= settings.compared_area * panel_area(base.panel(one.panel)) for one in pair)
    )
    areas = [float(np.log(a.measure(base) / b.measure(base))) for a, b in compared]
    lengths = [float(np.log(_length(base, a) / _length(base, b))) for a, b in edges]
    directed, across, spread = _directions(base, {frozenset(pair) for pair in sisters}, settings)
    vectors = kept_vectors(base)
    drawn = vectors @ base.points.ravel()
    widths = (
        *find_armhole_pairs(base),
        *(width for pair in sisters for width in _across_sisters(base, *pair)),
        *(width for pair in sisters for width in _across_openings(base, *pair, settings.unlike_length)),
    )
    notched = _consecutive_seam_edges(base)
    notches = [float(np.log(_length(base, a) / _length(base, b))) for a, b in notched]
    ratios = [_ln_distance(base, one)[0] - _ln_distance(base, other)[0] for one, other in widths]
    return Proportions(
        settings, compared, np.array(areas), tuple(edges), np.array(lengths), notched, np.array(notches), widths,
        np.array(ratios), vectors, drawn, directed, across, spread,
    )  # fmt: skip


def _directions(
    base: Pattern, sisters: set[frozenset[str]], settings: ProportionSettings
) -> tuple[tuple[EdgeRef, ...], np.ndarray, np.ndarray]:
    """Return the edges that are no seam between sisters, unit vectors across their chords and their spreads."""
    between = {
        ref for seam in base.seams if frozenset((seam.a.panel, seam.b.panel)) in sisters for ref in (seam.a, seam.b)
    }
    directed, across, spread = [], [], []
    for panel in base.panels:
        warp = np.array([-np.sin(panel.grainline), np.cos(panel.grainline)])
        for i, edge in enumerate(panel.edges):
            ref = EdgeRef(panel.name, i)
            if ref in between or edge_length(panel, i) < MIN_GRADED_EDGE_LENGTH:
                continue
            chord = panel.points[(i + 1) % len(panel.points)] - panel.points[i]
            chord = chord / np.linalg.norm(chord)
            off = min(abs(float(warp @ chord)), abs(float(warp[0] * chord[1] - warp[1] * chord[0])))
            directed.append(ref)
            across.append((-chord[1], chord[0]))
            is_threaded = edge.kind == "line" and off < np.sin(settings.thread_angle)
            spread.append(settings.thread_std if is_threaded else settings.direction_std)
    return tuple(directed), np.array(across).reshape(-1, 2), np.array(spread)


def _match_sister_edges(base: Pattern, first: str, second: str) -> list[tuple[EdgeRef, EdgeRef]]:
    """Pair edges of two sister panels, the second reversed, between common seams, if equal in number and kinds."""
    partner = _sewn_edges(base, first, second)
    count, other = len(base.panel(first).edges), len(base.panel(second).edges)
    pairs = []
    for start in sorted(partner):
        edges = edges_until(start, count, 1, set(partner))
        end = (edges[-1] + 1 if edges else start + 1) % count
        sister_edges = edges_until(partner[start], other, -1, set(partner.values()))
        meets = (sister_edges[-1] - 1 if sister_edges else partner[start] - 1) % other
        if not edges or partner[end] != meets or len(edges) != len(sister_edges):
            continue
        alike = [
            base.panel(first).edges[i].kind == base.panel(second).edges[j].kind
            for i, j in zip(edges, sister_edges, strict=True)
        ]
        if all(alike):
            pairs += [(EdgeRef(first, i), EdgeRef(second, j)) for i, j in zip(edges, sister_edges, strict=True)]
    return pairs


def _across_sisters(base: Pattern, first: str, second: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Pair the widths of two sister panels at inner points of two seams that join them and mirror each other.

    On a smooth side its seam can drift forwards at the waist and backwards at the hip. The seams' ends are left out:
    `_match_sister_edges` keeps hems and necklines, `find_armhole_pairs` the chest.
    """
    panel = base.panel(first)
    first_index, second_index = base.first_points[first], base.first_points[second]
    runs = _common_seams(base, first, second)
    found = []
    for n, run in enumerate(runs):
        for other in runs[n + 1 :]:
            ends = (run[0][0], run[-1][0]), (other[0][0], other[-1][0])
            if len(run) != len(other) or not are_mirrored(panel.points, *ends):
                continue
            for (a, sister_a), (b, sister_b) in zip(run[1:-1], other[-2:0:-1], strict=True):
                found.append(((first_index + a, first_index + b), (second_index + sister_a, second_index + sister_b)))
    return found


def _across_openings(
    base: Pattern, first: str, second: str, unlike: float
) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Pair the widths of two sister panels at an open contour that is longer on the one by a factor: a V in front.

    Both begin at the ends of the same two seams. Published drafts have equal widths within 1 cm (W. Aldrich, Metric
    Pattern Cutting for Women's Wear: a fifth of the neck less 0.2 cm behind, less 0.7 cm in front). For contours of
    like length `_match_sister_edges` keeps the width.
    """
    panel, sister, found = base.panel(first), base.panel(second), []
    first_index, second_index = base.first_points[first], base.first_points[second]
    runs = sorted(_common_seams(base, first, second))
    for run, following in zip(runs, [*runs[1:], *runs[:1]], strict=True):
        (start, there), (end, back) = run[-1], following[0]
        between = edges_until((start - 1) % len(panel.edges), len(panel.edges), 1, {end})
        opposite = edges_until((back - 1) % len(sister.edges), len(sister.edges), 1, {there})
        if not between or not opposite or not all(panel.edges[i].contour for i in between):
            continue
        lengths = [sum(edge_length(one, i) for i in each) for one, each in ((panel, between), (sister, opposite))]
        if max(lengths) > unlike * min(lengths):
            found.append(((first_index + start, first_index + end), (second_index + there, second_index + back)))
    return found


def _common_seams(base: Pattern, first: str, second: str) -> list[list[tuple[int, int]]]:
    """Return the seams between two panels as runs of points of the first, each with the second's sewn to it."""
    partner = _sewn_edges(base, first, second)
    count, other = len(base.panel(first).edges), len(base.panel(second).edges)

    def goes_on(edge: int) -> bool:
        return partner.get((edge + 1) % count) == (partner[edge] - 1) % other

    runs = []
    for start in sorted(
        edge for edge in partner if (edge - 1) % count not in partner or not goes_on((edge - 1) % count)
    ):
        edges = [start]
        while goes_on(edges[-1]) and len(edges) < count:
            edges.append((edges[-1] + 1) % count)
        run = [(edge, (partner[edge] + 1) % other) for edge in edges]
        runs.append([*run, ((edges[-1] + 1) % count, partner[edges[-1]])])
    return runs


def _sewn_edges(base: Pattern, first: str, second: str) -> dict[int, int]:
    """Return the edges of a panel that are sewn to another, each with the other's edge."""
    return {
        one.edge: other.edge
        for seam in base.seams
        for one, other in ((seam.a, seam.b), (seam.b, seam.a))
        if one.panel == first and other.panel == second
    }


def _consecutive_seam_edges(base: Pattern) -> tuple[tuple[EdgeRef, EdgeRef], ...]:
    """Pair the consecutive edges of one seam between two panels, on the first of both by name, across closed darts."""
    sewn = {ref: other for seam in base.seams for ref, other in ((seam.a, seam.b), (seam.b, seam.a))}
    found = []
    for ref, other in sewn.items():
        following, before = _skip_darts(base, ref, 1, sewn), _skip_darts(base, other, -1, sewn)
        if ref.panel < other.panel and sewn.get(following) == before:
            found.append((ref, following))
    return tuple(pair for pair in found if min(_length(base, each) for each in pair) >= MIN_GRADED_EDGE_LENGTH)


def _skip_darts(base: Pattern, ref: EdgeRef, turn: int, sewn: Mapping[EdgeRef, EdgeRef]) -> EdgeRef:
    """Return the next edge of a panel, forwards or backwards, past darts, whose two edges are sewn together."""
    count = len(base.panel(ref.panel).edges)
    at = (ref.edge + turn) % count
    while sewn.get(EdgeRef(ref.panel, at)) == EdgeRef(ref.panel, (at + turn) % count):
        at = (at + 2 * turn) % count
    return EdgeRef(ref.panel, at)


def _ln_distance(pattern: Pattern, pair: tuple[int, int]) -> tuple[float, np.ndarray]:
    """Return the logarithm of the distance of two control points [m] and its rates [1/m], shape [point_count, 2]."""
    one, other = pair
    apart = pattern.points[other] - pattern.points[one]
    rates = np.zeros((len(pattern.points), 2))
    rates[other] = apart / float(apart @ apart)
    rates[one] = -rates[other]
    return float(np.log(np.linalg.norm(apart))), rates


def _length(pattern: Pattern, ref: EdgeRef) -> float:
    return edge_length(pattern.panel(ref.panel), ref.edge)


def _length_rate(pattern: Pattern, ref: EdgeRef) -> np.ndarray:
    """Return d ln length / d points of an edge [1/m], shape [point_count, 2]: a curve follows its chord."""
    return _ln_distance(pattern, pattern.ends_of(ref))[1]


def area_growth(pattern: Pattern) -> np.ndarray:
    """Compute d ln A / d points of all panels' area A together, curves with it [1/m], shape [point_count, 2]."""
    rates = [area_rates_by_points(pattern, panel.name, range(len(panel.edges))) for panel in pattern.panels]
    found: np.ndarray = np.sum(rates, axis=0) / sum(panel_area(panel) for panel in pattern.panels)
    return found
