"""Find what in the scan shows each opening of a garment, and which are only inferred."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..geometry.curves import Curve
from ..geometry.geometry import face_areas, lump, unit, vertex_normals
from ..geometry.surface import TriangleSurface
from ..scan.contours.target import Contour
from ..scan.scan import Scan
from .colour import CONTRAST
from .confidence import contour_confidence, is_shown
from .lab import to_lab
from .part import GARMENTS, Part
from .separation import FoundContour

BORDER_SIDE_DISTANCE = 0.012
"""Distance of the compared places from a border [m]: beyond the cut's smoothing (8 mm), below half a narrow strap."""

BORDER_AVERAGING_RADIUS = 0.012
"""Radius over which height and colour of each side are averaged [m]: some ten points, and less than a fold."""

TANGENT_VERTEX_COUNT = 3
"""Number of vertices on either side from which a border's tangent is computed: a centimetre."""

MAX_FREE_EDGE_DISTANCE = 0.2
"""Largest distance between a free edge and the nearest other surface [m]: a wide skirt's hem hangs that far from the
legs. Where nothing else was scanned within it, the scan ends there and not the garment."""

MIN_LAYER_STEP = 2e-3
"""Least step at a border that shows which side is on the other [m]: the thickness of cloth and a scan's noise."""

WAISTBAND_HEIGHT_LOGISTIC = (0.04, 0.03)
"""Centre and scale of a logistic function of the height over the hip joints [m]: from the centre on, a border of two
garments is more likely a waistband than a hem. Waistbands that are seen are 8 to 20 cm above the joints, tops that hang
over end below; and a tucked top blouses over the band, so that by the step alone it would seem to hang over."""


BORDER_DOUBT_DISTANCES = (0.05, 0.08)
"""Distances from a border [m]: doubts of labels nearer than the first are doubts of where it is, as far as they exceed
those between the two, which are of what is worn; farther off, other borders begin."""

INTERVAL_DEVIATIONS = 1.645
"""Half the width of a normal distribution's 0.9 interval in standard deviations [1]."""

HIDDEN_WAIST_INTERVAL = INTERVAL_DEVIATIONS * 0.036
"""Half the width of the 0.9 interval of a waist below a top [m]: where its base pattern puts it, 20 garments of other
simulators have it with a standard deviation of 36 mm. Of hidden hems and necklines nothing is known."""

NORMAL_INTERVAL_RATIO = INTERVAL_DEVIATIONS * np.sqrt(np.pi / 2.0)
"""Half the width of a normal distribution's 0.9 interval over its mean absolute deviation [1]."""


@dataclass(frozen=True)
class Surroundings:
    """Describe a labelled scan, to compare both sides of a border.

    Attributes:
        points: Positions [m], shape [n, 3].
        label: A `Part` for each, shape [n].
        lab: Colours in L*a*b*, shape [n, 3], or None.
        height: Over the body [m], shape [n].
        hips: Height of the hip joints [m].
        area: Of each [m2], shape [n].
        doubt: Probability that its label is wrong under the best reading, shape [n].
    """

    points: np.ndarray
    label: np.ndarray
    lab: np.ndarray | None
    height: np.ndarray
    hips: float
    area: np.ndarray
    doubt: np.ndarray

    @classmethod
    def of(cls, whole: Scan, label: np.ndarray, certainty: np.ndarray, body: Body) -> Surroundings:
        """Compute colours of a labelled scan, its heights over the body, and where its labels are doubted.

        Args:
            whole: The scan.
            label: A `Part` for each vertex, shape [n].
            certainty: Probability of each under the best reading, shape [n].
            body: The wearer.
        """
        height = TriangleSurface(body.vertices, body.faces).heights(whole.vertices)
        lab = None if whole.colours is None else to_lab(whole.colours) * CONTRAST
        hips = float(0.5 * (body.joint("left_hip")[1] + body.joint("right_hip")[1]))
        area = lump(face_areas(whole.vertices, whole.faces), whole.faces, len(whole.vertices))
        return cls(whole.vertices, label, lab, height, hips, area, 1.0 - certainty)


@dataclass(frozen=True)
class BorderSides:
    """Describe what is beyond a border, place by place.

    Attributes:
        step: Height of the garment over it [m], shape [n].
        contrast: Difference of the two sides' colours, shape [n].
        next_part: A `Part`, shape [n]; -1 where the garment's edge is free, -2 where nothing was seen.
        level: Height of the border over the hip joints [m].
    """

    step: np.ndarray
    contrast: np.ndarray
    next_part: np.ndarray
    level: float


def find_openings(
    garment: Scan, contours: tuple[Contour, ...], part: Part, around: Surroundings
) -> tuple[FoundContour, ...]:
    """Classify each opening of a garment by what is on its two sides.

    An opening is shown by a step down from the garment to what is beyond, by a change of colour, or by a free edge with
    the wearer further in. It is inferred where another garment covers it, or where nothing was scanned beyond.

    Args:
        garment: As it was cut out of the scan.
        contours: Its named contours.
        part: Which garment it is.
        around: The scan that it was cut out of.
    """
    inside, outside = np.flatnonzero(around.label == part), np.flatnonzero(around.label != part)
    trees = cKDTree(around.points[inside]), cKDTree(around.points[outside])
    normals = vertex_normals(garment.vertices, garment.faces)
    found = []
    for contour in contours:
        points, loop = garment.vertices[contour.vertices], contour.vertices
        tangent = np.roll(points, -TANGENT_VERTEX_COUNT, axis=0) - np.roll(points, TANGENT_VERTEX_COUNT, axis=0)
        left = BORDER_SIDE_DISTANCE * unit(np.cross(normals[loop], unit(tangent)))  # into the garment
        inner = [inside[rows] for rows in trees[0].query_ball_point(points + left, BORDER_AVERAGING_RADIUS)]
        other = [outside[rows] for rows in trees[1].query_ball_point(points - left, BORDER_AVERAGING_RADIUS)]
        is_free = np.isfinite(trees[1].query(points - left, distance_upper_bound=MAX_FREE_EDGE_DISTANCE)[0])
        sides = _compare_sides(around, inner, other, is_free, float(np.median(points[:, 1]) - around.hips))
        beyond = Part(int(np.bincount(sides.next_part[sides.next_part >= 0], minlength=1).argmax()))
        covered = is_covered(part, sides)
        if covered:
            interval = HIDDEN_WAIST_INTERVAL if contour.name == "waist" else None
        else:
            interval = measure_interval(around, contour.curve(garment.vertices), (part, beyond))
        found.append(replace(_classify_opening(contour.name, sides, covered), interval=interval))
    return tuple(found)


def measure_interval(around: Surroundings, border: Curve, parts: tuple[Part, Part]) -> float:
    """Return half the width of the interval that a border lies in with a probability of 0.9 [m].

    A point at a distance x from where the border was found is labelled wrongly if the border lies beyond it, so that
    the integral of that probability over x is the mean absolute deviation of the border: the sum of areas times
    doubts beside it, over its length. What labels farther off are doubted on the same side is not the border's.

    Args:
        around: The labelled scan.
        border: Its curve [m].
        parts: The garment and what is beyond the border; other labels are doubted for other borders.
    """
    close, far = BORDER_DOUBT_DISTANCES
    distance = cKDTree(border.points).query(around.points, distance_upper_bound=far)[0]
    doubted = 0.0
    for part in parts:
        near, beside = ((around.label == part) & (distance < reach) for reach in (close, far))
        beside &= ~near & (around.area > 0.0)
        general = np.average(around.doubt[beside], weights=around.area[beside]) if beside.any() else 0.0
        doubted += max(float((around.area * (around.doubt - general))[near].sum()), 0.0)
    return float(NORMAL_INTERVAL_RATIO * doubted / border.length)


def _compare_sides(
    around: Surroundings, inside: list[np.ndarray], other: list[np.ndarray], is_free: np.ndarray, level: float
) -> BorderSides:
    """Compare the two sides of a border, each given by the points near each of its places."""
    step, contrast = np.zeros(len(inside)), np.zeros(len(inside))
    beyond = np.where(is_free, -1, -2)
    step[is_free] = MAX_FREE_EDGE_DISTANCE
    for i, (a, b) in enumerate(zip(inside, other, strict=True)):
        if not len(b):
            continue
        beyond[i] = np.bincount(around.label[b]).argmax()
        step[i] = around.height[a].mean() - around.height[b].mean() if len(a) else 0.0
        if around.lab is not None and len(a):
            contrast[i] = np.linalg.norm(around.lab[a].mean(axis=0) - around.lab[b].mean(axis=0))
    return BorderSides(step, contrast, beyond, level)


def is_covered(part: Part, sides: BorderSides) -> bool:
    """Check whether something else lies over a garment's border, so that it ends somewhere below that."""
    worn = np.isin(sides.next_part, GARMENTS)
    covered = worn.mean() > 0.5 and _lies_below(part, sides.next_part[worn], sides.step[worn], sides.level)
    # hair is over clothes; OTHER below the garment may be its own inside
    over = (sides.next_part == Part.HAIR) | ((sides.next_part == Part.OTHER) & (sides.step < MIN_LAYER_STEP))
    return bool(covered or over.mean() > 0.5)


def _classify_opening(name: str, sides: BorderSides, covered: bool) -> FoundContour:
    worn = np.isin(sides.next_part, GARMENTS)
    step = np.where(worn, np.abs(sides.step), sides.step)  # a garment's edge is seen from either side
    shown = not covered and is_shown(step, sides.contrast)
    return FoundContour(name, contour_confidence(step, sides.contrast), not shown)


def _lies_below(part: Part, next_part: np.ndarray, step: np.ndarray, height: float) -> bool:
    """Check whether the garment beyond a border is over this one.

    The step decides, and if it is small the border's height: below the waist the upper garment hangs over the lower.
    """
    other = Part(int(np.bincount(next_part).argmax()))
    below = -float(np.median(step)) / MIN_LAYER_STEP
    if Part.OUTER in (part, other):
        return below + (2.0 if other is Part.OUTER else -2.0) > 0.0
    hanging = (WAISTBAND_HEIGHT_LOGISTIC[0] - height) / WAISTBAND_HEIGHT_LOGISTIC[1]
    return below + (hanging if part is Part.LOWER else -hanging) > 0.0
