"""Choose the collar and the front of a garment by the cloth at its neck: upright, turned over, slit, or none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...body.body import JOINTS, Body
from ...garment.creases import find_turned_panels
from ...garment.curves import panel_area
from ...garment.parts.collars import STRIP_COLLARS
from ...garment.parts.cut import Collar, Cut, Front, Neckline, PartsConflict
from ...garment.parts.draft import draft_cut
from ...garment.parts.turned_collars import BREAK_DEPTH, LAPELLED_COLLARS
from ...geometry.geometry import face_areas, face_normals
from ...geometry.surface import TriangleSurface
from ...scan.contours.edge_turn import EdgeTurn
from ...scan.contours.target import Contour, Target
from ...scan.contours.turned import find_turned_faces

TURNED_AREA_STD = (0.25, 0.002)
"""Standard deviation of the area that is turned over: share of a collar's own area, since collars differ in width, and
folds and noise of cloth that has none [1, m2]. Five collars had 0.93 to 1.05 of their drafts' area, round and V-necks
0."""

STANDING_AREA_STD = 0.004
"""Standard deviation of the area of cloth over the skin of the neck [m2]: a centimetre around it. A round neck has 0,
a stand 0.002, a turtleneck 0.017."""

EDGE_SLOPE_WIDTH = 0.015
"""Width of the strip along the edge whose slope is measured [m]: half a stand."""

EDGE_SLOPES: Mapping[Collar, float] = {Collar.STAND: 0.37, Collar.TURTLENECK: 0.0}
"""Mean cosine of the cloth's normals along the edge with the trunk's direction where a strip stands upright [1]."""

FLAT_EDGE_SLOPE = 0.57
"""The same without one [1]: of twelve tops without a collar 0.44 to 0.64, of two stands 0.33 and 0.41."""

EDGE_SLOPE_STD = 0.06
"""Standard deviation of that cosine [1]."""

TURNED_DEPTH_STD = 0.04
"""Standard deviation of the depth below the neck to which a part is turned over [m]: break points of lapels are a
button's distance apart. Falls end 0.10 to 0.13 m below the neck joint, lapels 0.28."""

FALL_DEPTH = 0.11
"""Depth below the neck joint to which a fall reaches in front [m]: the points of a shirt's collar."""

CREW_DEPTH = 0.03
"""Width of a strip around a crew neck that is not above the skin of the chest and the shoulders [m]: necklines lie that
far outside the line where neck and shoulders meet."""

NECK_GIRTH = 0.36
"""Girth of a neck [m]: that of women and men of mean size, 0.34 and 0.38."""

MIN_CORNER_COUNT = 2
"""Number of corners of the edge, one on each side, from which it is no shawl collar's [1]: a shirt's has its points, a
jacket's those of collar and lapels."""

MIN_SLIT_LENGTH = 0.05
"""Length from which two edges beside each other are a placket and no V [m]: a first button and half the next one."""

MAX_SLIT_WIDTH = 0.02
"""Distance of the edges of a closed placket [m]: its overlap."""

RARE_COST = 2.0
"""Misfit of a strip that stands upright, and of a front that a collar is not usually cut with [standard
deviations]: one garment in seven, exp(-2)."""

USUAL_FRONTS: Mapping[Collar, tuple[Front, ...]] = {
    Collar.NONE: (Front.NONE, Front.PLACKET, Front.OPEN),
    Collar.RIB: (Front.NONE,),
    Collar.TURTLENECK: (Front.NONE,),
    Collar.STAND: (Front.ZIP, Front.OPEN),
    Collar.SHIRT: (Front.BUTTONS, Front.OPEN),
    Collar.CONVERTIBLE: (Front.BUTTONS, Front.OPEN),
    Collar.POLO: (Front.PLACKET,),
    Collar.NOTCHED: (Front.BUTTONS, Front.OPEN),
    Collar.SHAWL: (Front.BUTTONS, Front.OPEN),
}
"""Fronts that a collar is usually cut with, the first where the scan shows a closed one."""


@dataclass(frozen=True)
class NeckShape:
    """Describe the cloth at a garment's neck.

    Attributes:
        turned: Area that is turned over [m2].
        depth: Depth of its lowest place below the neck joint [m]; 0 where nothing is turned over.
        standing: Area over the skin of the neck that is not turned over [m2].
        slope: Mean cosine of the normals along the edge with the trunk's direction [1].
        slit: Length of a slit in front [m]; 0 where there is none.
        is_open: Whether the front is open down to the hem.
        corners: Number of corners of the edge.
    """

    turned: float
    depth: float
    standing: float
    slope: float
    slit: float
    is_open: bool
    corners: int

    @classmethod
    def of(cls, target: Target, body: Body) -> NeckShape | None:
        """Measure a target; None without a neck that the scan shows."""
        neck = target.contour("neck")
        if neck is None or not neck.trusted or not len(target.faces):
            return None
        vertices, faces = target.vertices, target.faces
        turned, areas = find_turned_faces(vertices, faces, neck, body), face_areas(vertices, faces)
        centres = vertices[faces].mean(axis=1)
        depth = float(body.joint("neck")[1] - centres[turned, 1].min()) if turned.any() else 0.0
        standing = float(areas[_is_over_neck(centres, body) & ~turned].sum())
        corners = len(EdgeTurn.of_target(neck, target).corners())
        is_open = target.contour("front.left") is not None
        slit = 0.0 if is_open else measure_slit(vertices[neck.vertices])
        slope = _measure_slope(target, neck, body)
        return cls(float(areas[turned].sum()), depth, standing, slope, slit, is_open, corners)


def _is_over_neck(points: np.ndarray, body: Body) -> np.ndarray:
    """Return which points [m], shape [n, 3], are nearest to the skin of neck or head."""
    found = TriangleSurface(body.vertices, body.faces).closest(points)
    columns = [JOINTS.index(name) for name in ("neck", "head")]
    return np.asarray(body.weights[body.faces[found.face]].mean(axis=1)[:, columns].sum(axis=1) > 0.5)


def _measure_slope(target: Target, neck: Contour, body: Body) -> float:
    """Return the mean cosine of the normals within `EDGE_SLOPE_WIDTH` of the neck's edge with the trunk's direction."""
    normals, areas = face_normals(target.vertices, target.faces)
    centres = target.vertices[target.faces].mean(axis=1)
    near = cKDTree(target.vertices[neck.vertices]).query(centres, distance_upper_bound=EDGE_SLOPE_WIDTH)[0]
    beside = np.isfinite(near) | np.isin(target.faces, neck.vertices).any(axis=1)
    up = body.joint("neck") - body.joint("spine2")
    return float(np.average(normals[beside] @ (up / np.linalg.norm(up)), weights=areas[beside]))


def measure_slit(loop: np.ndarray) -> float:
    """Measure the longest slit of an edge [m]: a stretch that runs within `MAX_SLIT_WIDTH` beside another, from its
    lowest point upwards.

    Args:
        loop: Points along the closed edge [m], shape [n, 3].
    """
    low, count = int(loop[:, 1].argmin()), len(loop)
    length, first, second = 0.0, low, low
    for _ in range(count // 2):
        before, after = (first - 1) % count, (second + 1) % count
        # the side whose next point is lower climbs first, so that both stay at one height
        if loop[before, 1] < loop[after, 1]:
            first = before
        else:
            second = after
        if float(np.linalg.norm(loop[first] - loop[second])) > MAX_SLIT_WIDTH:
            break
        length = float(min(loop[first, 1], loop[second, 1]) - loop[low, 1])
    return length


@dataclass(frozen=True)
class NeckFinish:
    """Describe a collar and a front with their misfit [standard deviations]."""

    collar: Collar
    front: Front
    misfit: float

    def apply(self, cut: Cut) -> Cut:
        """Return a cut with them; a collar is sewn to a crew neck."""
        cut = replace(cut, collar=self.collar, front=self.front)
        if self.collar is Collar.NONE:
            return cut
        return replace(cut, neckline=Neckline.CREW, back_neckline=Neckline.CREW)


def rank_finishes(shape: NeckShape, cut: Cut, fixed: Mapping[str, str]) -> tuple[NeckFinish, ...]:
    """Rank collars and fronts by the likelihood of a scan's neck, best first.

    The misfit is the root of the sum of squares of the deviations from what a draft has there, in standard deviations:
    of the area turned over, the depth it reaches, the cloth over the neck, the slope of an edge that is not turned, and
    whether the edge has corners. An open front and a slit are seen; which of the closed fronts it is, is not, and the
    usual one for the collar is taken. A rib lies as the garment's own cloth would, and is only the user's choice. Those
    that are less likely than the first by more than `RARE_COST` are left out.

    Args:
        shape: Of the scan's neck.
        cut: That they are drafted on.
        fixed: Choices of the user, by part.
    """
    found, collars = [], list(Collar)
    collars.remove(Collar.RIB)
    if "collar" in fixed:
        collars = [Collar(fixed["collar"])]
    elif {fixed.get(part, "crew") for part in ("neckline", "back_neckline")} != {"crew"}:
        collars = [Collar.NONE]
    for collar in collars:
        front = Front(fixed["front"]) if "front" in fixed else _choose_front(shape, collar)
        deviation = _deviate(shape, cut, NeckFinish(collar, front, 0.0))
        if deviation is not None:
            is_shown = front is not Front.PLACKET or shape.slit > MIN_SLIT_LENGTH
            is_usual = front in USUAL_FRONTS[collar] and is_shown
            costs = [RARE_COST * (not is_usual), RARE_COST * (collar in EDGE_SLOPES)]
            found.append(NeckFinish(collar, front, float(np.linalg.norm([deviation, *costs]))))
    least = min((one.misfit for one in found), default=0.0)
    likely = [one for one in found if one.misfit <= least + RARE_COST]
    return tuple(sorted(likely, key=lambda one: one.misfit))


def _choose_front(shape: NeckShape, collar: Collar) -> Front:
    """Return the front that a scan shows, or the usual closed one for a collar."""
    if shape.is_open:
        return Front.OPEN
    if shape.slit > MIN_SLIT_LENGTH:
        return Front.PLACKET
    return next(front for front in USUAL_FRONTS[collar] if front is not Front.OPEN)


def _deviate(shape: NeckShape, cut: Cut, finish: NeckFinish) -> float | None:
    """Return the deviation of a scan's neck from a collar's [standard deviations]; None where it is not drafted."""
    collar = finish.collar
    try:
        pattern = draft_cut(finish.apply(cut))
    except PartsConflict:
        return None
    names, has_lapels = find_turned_panels(pattern), collar in LAPELLED_COLLARS
    turned = sum(panel_area(panel) for panel in pattern.panels if panel.name in names)
    standing = 0.0
    if collar in STRIP_COLLARS:
        standing = max(0.0, STRIP_COLLARS[collar].width - CREW_DEPTH) * NECK_GIRTH
    share, least = TURNED_AREA_STD
    terms = [
        (shape.turned - turned) / np.hypot(share * turned, least),
        (shape.standing - standing) / STANDING_AREA_STD,
    ]
    if not turned:
        terms.append((shape.slope - EDGE_SLOPES.get(collar, FLAT_EDGE_SLOPE)) / EDGE_SLOPE_STD)
    if turned and shape.turned:
        terms.append((shape.depth - (BREAK_DEPTH if has_lapels else FALL_DEPTH)) / TURNED_DEPTH_STD)
        terms.append(0.0 if (collar is Collar.SHAWL) == (shape.corners < MIN_CORNER_COUNT) else 1.0)
    return float(np.linalg.norm(terms))
