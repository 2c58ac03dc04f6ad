"""Choose collar, hood and front of a garment by the cloth at its neck: upright, turned over, slit, or none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...body.body import JOINTS, Body
from ...garment.creases import find_turned_panels
from ...garment.curves import flat_contours, panel_area
from ...garment.parts.collars import STRIP_COLLARS
from ...garment.parts.cut import Collar, Cut, Front, Hood, HoodWorn, Neckline, PartsConflict
from ...garment.parts.draft import draft_cut
from ...garment.parts.hoods import HOOD_LABEL
from ...garment.parts.turned_collars import BREAK_DEPTH, LAPELLED_COLLARS
from ...geometry.geometry import face_areas, face_normals
from ...geometry.surface import ClosestPoints, TriangleSurface
from ...scan.contours.edge_turn import EdgeTurn
from ...scan.contours.target import Contour, Target
from ...scan.contours.turned import join_turned_faces

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

BEHIND_SHARE_STD = 0.15
"""Standard deviation of the share of what is turned over that is behind the neck joint [1]."""

COLLAR_BEHIND_SHARE, HOOD_BEHIND_SHARE = 0.37, 0.85
"""That share of collars, with lapels or without (0.32 to 0.43), and of a hood behind the neck (0.87) [1]."""

FALL_DEPTH = 0.11
"""Depth below the neck joint to which a fall reaches in front [m]: the points of a shirt's collar."""

CREW_DEPTH = 0.03
"""Width of a strip around a crew neck that is not above the skin of the chest and the shoulders [m]: necklines lie that
far outside the line where neck and shoulders meet."""

NECK_GIRTH = 0.36
"""Girth of a neck [m]: that of women and men of mean size, 0.34 and 0.38."""

HOOD_SHOWN_SHARES: Mapping[HoodWorn, tuple[float, float]] = {HoodWorn.UP: (0.0, 0.87), HoodWorn.DOWN: (0.27, 0.08)}
"""Shares of a hood's area that are turned over, and that are over head and neck and are not [1]. Behind the neck it
folds as it falls: of two hoods 0.54 and 0.01 were turned over, 0.03 and 0.14 over the neck."""

HOOD_AREA_STD = 0.2
"""Standard deviation of either share of a hood behind the neck [1]."""

EDGE_LENGTH_STD = 0.2
"""Standard deviation of the logarithm of an edge's length [1]: sizes differ by a tenth, and folds bridge another."""

HOOD_DEPTH = 0.20
"""Depth below the neck joint to which the inside of a hood shows behind the neck [m]."""

MIN_CORNER_COUNT = 2
"""Number of corners of the edge, one on each side, from which it is no shawl collar's [1]: a shirt's has its points, a
jacket's those of collar and lapels."""

MIN_SLIT_LENGTH = 0.03
"""Length from which two edges beside each other are a placket [m]: its first button is 2 cm below the neck. The lowest
point of a V is less than `MAX_SLIT_WIDTH` wide over 2.5 cm; the border of a closed shirt ends 2 cm below its fall."""

MAX_SLIT_WIDTH = 0.02
"""Distance of the edges of a closed placket [m]: its overlap."""

RARE_COST = 2.0
"""Misfit of a strip that stands upright, of a hood, and of a front that a collar is not usually cut with [standard
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
        behind: Share of the area turned over that is behind the neck joint [1]; 0 where nothing is turned over.
        standing: Area over the skin of the neck that is not turned over [m2].
        slope: Mean cosine of the normals along the edge with the trunk's direction [1].
        slit: Length of a slit in front [m], below a collar also of one that falls open; 0 where there is none.
        is_open: Whether the front is open down to the hem.
        corners: Number of corners of the edge.
        length: Of the edge [m].
    """

    turned: float
    depth: float
    behind: float
    standing: float
    slope: float
    slit: float
    is_open: bool
    corners: int
    length: float

    @classmethod
    def of(cls, target: Target, body: Body) -> NeckShape | None:
        """Measure a target; None without a neck that the scan shows."""
        neck = target.contour("neck")
        if neck is None or not neck.trusted or not len(target.faces):
            return None
        vertices, faces = target.vertices, target.faces
        centres, areas = vertices[faces].mean(axis=1), face_areas(vertices, faces)
        skin = TriangleSurface(body.vertices, body.faces)
        found = skin.closest(centres)
        turned = join_turned_faces(vertices, faces, neck, skin, found)
        depth = float(body.joint("neck")[1] - centres[turned, 1].min()) if turned.any() else 0.0
        lateral = (body.joint("left_shoulder") - body.joint("right_shoulder")) * (1.0, 0.0, 1.0)
        is_behind = (centres - body.joint("neck")) @ np.cross(lateral, (0.0, 1.0, 0.0)) < 0.0
        behind = float(areas[turned & is_behind].sum() / max(areas[turned].sum(), 1e-12))
        standing = float(areas[_is_over_neck(found, body) & ~turned].sum())
        corners = len(EdgeTurn.of_target(neck, target).corners())
        is_open = target.contour("front.left") is not None
        loop = vertices[neck.vertices]
        slit = 0.0 if is_open else measure_slit(loop)
        if areas[turned].sum() > TURNED_AREA_STD[1] and not is_open:
            slit = max(slit, float(body.joint("neck")[1] - loop[:, 1].min()) - depth)
        slope = _measure_slope(target, neck, body)
        return cls(float(areas[turned].sum()), depth, behind, standing, slope, slit, is_open, corners, neck.length)


def _is_over_neck(found: ClosestPoints, body: Body) -> np.ndarray:
    """Return which of the closest points of a body are on the skin of neck or head, shape [n]."""
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
    """Describe a collar, or a hood and how it is worn, and a front, with their misfit [standard deviations]."""

    collar: Collar
    front: Front
    hood: Hood = Hood.NONE
    hood_worn: HoodWorn = HoodWorn.DOWN
    misfit: float = 0.0

    def apply(self, cut: Cut) -> Cut:
        """Return a cut with them; collars and hoods are sewn to a crew neck."""
        cut = replace(cut, collar=self.collar, front=self.front, hood=self.hood, hood_worn=self.hood_worn)
        if self.collar is Collar.NONE and self.hood is Hood.NONE:
            return cut
        return replace(cut, neckline=Neckline.CREW, back_neckline=Neckline.CREW)


def rank_finishes(shape: NeckShape, cut: Cut, fixed: Mapping[str, str]) -> tuple[NeckFinish, ...]:
    """Rank collars, hoods and fronts by the likelihood of a scan's neck, best first.

    The misfit is the root of the sum of squares of the deviations from what a draft has there, in standard deviations:
    of the area turned over, its depth and its share behind, the cloth over the neck, the slope of an edge that is not
    turned, and whether the edge has corners. An open front and a slit are seen; which of the closed fronts it is, is
    not, and the usual one for the collar is taken. A rib lies as the garment's own cloth would, and a strip between the
    sides of a hood as these: both are only the user's choice. Those that are less likely than the first by more than
    `RARE_COST` are left out.

    Args:
        shape: Of the scan's neck.
        cut: That they are drafted on.
        fixed: Choices of the user, by part.
    """
    found = []
    for finish in _list_finishes(shape, fixed):
        expected = _expect(cut, finish)
        if expected is not None:
            is_shown = finish.front is not Front.PLACKET or shape.slit > MIN_SLIT_LENGTH
            is_upright = finish.collar in EDGE_SLOPES or finish.hood is not Hood.NONE
            is_rare = is_upright, finish.front not in USUAL_FRONTS[finish.collar] or not is_shown
            deviations = [*expected.deviate(shape), *(RARE_COST * rare for rare in is_rare)]
            found.append(replace(finish, misfit=float(np.linalg.norm(deviations))))
    least = min((one.misfit for one in found), default=0.0)
    likely = [one for one in found if one.misfit <= least + RARE_COST]
    return tuple(sorted(likely, key=lambda one: one.misfit))


def _list_finishes(shape: NeckShape, fixed: Mapping[str, str]) -> list[NeckFinish]:
    """Return the finishes that the user's choices leave, each with the front that the scan shows or is usual."""
    collars, hoods = list(Collar), [Hood.TWO]
    collars.remove(Collar.RIB)
    is_round = {fixed.get(part, "crew") for part in ("neckline", "back_neckline")} == {"crew"}
    if "collar" in fixed or not is_round:
        collars = [Collar(fixed.get("collar", "none"))]
        hoods = []
    if "hood" in fixed:
        hoods = [hood for hood in (Hood(fixed["hood"]),) if hood is not Hood.NONE]
        collars = [] if hoods else collars
    worn = [HoodWorn(fixed["hood_worn"])] if "hood_worn" in fixed else list(HoodWorn)
    found = []
    for collar in collars:
        found.append(NeckFinish(collar, Front(fixed["front"]) if "front" in fixed else _choose_front(shape, collar)))
    front = Front(fixed["front"]) if "front" in fixed else _choose_front(shape, Collar.NONE)
    return found + [NeckFinish(Collar.NONE, front, hood, how) for hood in hoods for how in worn]


def _choose_front(shape: NeckShape, collar: Collar) -> Front:
    """Return the front that a scan shows, or the usual closed one for a collar."""
    if shape.is_open:
        return Front.OPEN
    if shape.slit > MIN_SLIT_LENGTH:
        return Front.PLACKET
    return next(front for front in USUAL_FRONTS[collar] if front is not Front.OPEN)


@dataclass(frozen=True)
class _Expected:
    """Describe what a scan shows of a finish as it is drafted.

    Attributes:
        turned, depth, behind, standing, slope: As in `NeckShape`; None where the slope is not that of a plain edge.
        has_corners: Whether the edge has corners; None where they are not known.
        length: Of the edge [m]; None where it says nothing, as that of a plain neckline does.
        folds: Standard deviation of both areas where they follow from folds [m2]; 0 where they do not.
    """

    turned: float
    depth: float
    behind: float
    standing: float
    slope: float | None
    has_corners: bool | None
    length: float | None
    folds: float = 0.0

    def deviate(self, shape: NeckShape) -> list[float]:
        """Return the deviations of a scan [standard deviations]."""
        share, least = TURNED_AREA_STD
        turned_std = self.folds or float(np.hypot(share * self.turned, least))
        standing_std = self.folds or float(np.hypot(share * self.standing, STANDING_AREA_STD))
        found = [(shape.turned - self.turned) / turned_std, (shape.standing - self.standing) / standing_std]
        if self.length is not None and not shape.is_open:
            found.append(float(np.log(shape.length / self.length)) / EDGE_LENGTH_STD)
        if self.slope is not None:
            found.append((shape.slope - self.slope) / EDGE_SLOPE_STD)
        if self.turned and shape.turned > least:
            found.append((shape.depth - self.depth) / TURNED_DEPTH_STD)
            found.append((shape.behind - self.behind) / BEHIND_SHARE_STD)
            found.append(
                float(self.has_corners is not None and self.has_corners != (shape.corners >= MIN_CORNER_COUNT))
            )
        return found


def _expect(cut: Cut, finish: NeckFinish) -> _Expected | None:
    """Return what a scan shows of a finish that is drafted on a cut; None where it is not drafted on it."""
    try:
        pattern = draft_cut(finish.apply(cut))
    except PartsConflict:
        return None
    areas, length = {panel.name: panel_area(panel) for panel in pattern.panels}, flat_contours(pattern)["neck"]
    if finish.hood is not Hood.NONE:
        hood = sum(areas[panel.name] for panel in pattern.panels if panel.label == HOOD_LABEL)
        turned, standing = (share * hood for share in HOOD_SHOWN_SHARES[finish.hood_worn])
        folds = HOOD_AREA_STD * hood if finish.hood_worn is HoodWorn.DOWN else 0.0
        return _Expected(turned, HOOD_DEPTH, HOOD_BEHIND_SHARE, standing, None, None, length, folds)
    turned = sum(areas[name] for name in find_turned_panels(pattern))
    if turned:
        depth = BREAK_DEPTH if finish.collar in LAPELLED_COLLARS else FALL_DEPTH
        return _Expected(turned, depth, COLLAR_BEHIND_SHARE, 0.0, None, finish.collar is not Collar.SHAWL, length)
    slope = EDGE_SLOPES.get(finish.collar, FLAT_EDGE_SLOPE)
    if finish.collar not in STRIP_COLLARS:
        return _Expected(0.0, 0.0, 0.0, 0.0, slope, None, None)
    standing = max(0.0, STRIP_COLLARS[finish.collar].width - CREW_DEPTH) * NECK_GIRTH
    return _Expected(0.0, 0.0, 0.0, standing, slope, None, length)
