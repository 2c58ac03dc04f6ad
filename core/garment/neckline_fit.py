"""Find the kind of a scan's neckline, in front and behind, from the shape of its contour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..geometry.connectivity import HalfEdges
from ..geometry.curves import Curve, polyline_length
from ..geometry.geometry import angle_defects, rim_turns
from ..scan.contours.neck import unroll_neck
from ..scan.contours.target import Contour, Target
from .parts.cut import Neckline
from .parts.necklines import NecklineCut, corner_turn, neckline_points


@dataclass(frozen=True)
class NecklineSettings:
    """Describe from where a line counts as which neckline.

    Attributes:
        turn_std: Standard deviation of the window over which a contour's turn in the middle is summed [m]: two edges of
            a scan's mesh, two steps of a cut along triangles.
        strip_width: Width of the strip along a contour whose own curvature is subtracted from its turns [m]: fused
            scans round edges over 4 to 12 mm, and fold them onto the skin. Three scans of one V turned by 80, 93 and 30
            degrees at its point, less the strip's curvature by 109, 117 and 95.
        clear_misfit: Share of the round line's misfit below which another line is chosen, since most necklines are
            round. V-necks of three scans have 0.08 to 0.22, the crew necks of two 1.6 and more.
        v_turn: Smallest turn in the middle of a V [rad]. The shallowest V that is worn, 12 cm deep and 30 cm wide,
            turns by 77 degrees; round necklines of scans, fitted as Vs with bowed sides, by up to 37.
        v_turn_share: Smallest turn of a contour within its surface as a share of the V's: 0.8 to 1.06 on V-necks of six
            drapes, 0.3 where folds drew a round one together behind. `v_turn` applies too: a round line 18 cm wide
            turns by 32 degrees over the window, 0.63 of the turn of the most bowed V that a drape had drawn it to.
        surface_v_turn: Smallest turn in the middle within the cloth that makes a line a V [rad]: V-necks of nine drapes
            have 83 to 134 degrees, round ones at most 33, 60 with 2 mm of noise.
        v_misfit: Largest ratio of the misfit of a V to that of the round line, where the turn in the middle makes it a
            V: the sides of a tight V bulge until they are nearly round, with a ratio of 2.1.
        v_bows: Bows of a V's side that are tried [chords]; 0.15 is a quarter turn from end to end, and no V any more.
        square_turn: Smallest turn within the cloth at both lower corners of a square neckline [rad]. Squares of 13
            drapes have 40 to 90 degrees on both sides, less on coarser meshes, and at most 0.6 of it in the middle;
            round ones in front up to 46 on one side and 38 on both.
        square_misfit: Largest ratio of the misfit of a square, for a line with corners, to that of the round line: 1.3
            where its lower edge sags. Round lines behind, with corners at the side neck points, have 2.3 and more.
        square_depth: Depth up to which a line is no square [m], twice `turn_std`: its corners are as near to the side
            neck points, where round lines end in a corner, and the windows of both overlap. A shallow round line
            behind, flat with tight ends, had 52 to 64 degrees there, and a square's misfit was 0.59 to 1.4 of a round
            one's, with 2 mm of change either way.
        square_corners: Shares of a line's length from the middle between which a square's corner is searched.
        turn_ratio: Smallest ratio of the turn at the corners to the turn in the middle of a square, and of the turn in
            the middle to that at the corners of a V: round lines turn everywhere.
        scoop_depth: Ratio of depth to half width above which a round line is a scoop: midway between crew and scoop.
        boat_depth: Ratio of the same below which it is a boat; usually a boat has 0.3, a crew 1.1.
    """

    turn_std: float = 0.02
    strip_width: float = 0.015
    clear_misfit: float = 0.6
    v_turn: float = float(np.radians(45.0))
    v_turn_share: float = 0.5
    surface_v_turn: float = float(np.radians(75.0))
    v_misfit: float = 2.5
    v_bows: tuple[float, ...] = tuple(np.round(np.arange(-0.15, 0.151, 0.0125), 4).tolist())
    square_turn: float = float(np.radians(39.0))
    square_misfit: float = 1.5
    square_depth: float = 0.04
    square_corners: tuple[float, float] = (0.25, 0.9)
    turn_ratio: float = 1.5
    scoop_depth: float = 1.35
    boat_depth: float = 0.6


@dataclass(frozen=True)
class NecklineFit:
    """Describe the fit of one neckline, of a contour's depth and bow: the contour's half width [m], and the root mean
    square distance of the two lines [half widths]."""

    neckline: NecklineCut
    half_width: float
    misfit: float


@dataclass(frozen=True)
class NecklineFits:
    """Describe the fits of all necklines to a scan's contour, in front and behind, best first."""

    front: tuple[NecklineFit, ...]
    back: tuple[NecklineFit, ...]


def fit_necklines(target: Target, body: Body, settings: NecklineSettings = NecklineSettings()) -> NecklineFits | None:
    """Fit every neckline to a target's neck contour; None where that is missing, not trusted or cannot be unrolled.
    Folds can make a round neckline hang to a point, so a V has to turn within the cloth too: by the angles of the faces
    around the contour's vertices, which folds do not change. The corners of a square, whose lower edge sags, are found
    by the same angles."""
    contour = target.contour("neck")
    if contour is None or not contour.trusted:
        return None
    lines = unroll_neck(target.vertices[contour.vertices], body)
    if lines is None:
        return None
    rim = _Rim.of(target, contour, settings)
    front, back = (
        rim.turns_around(middle, polyline_length(line), settings)
        for line, middle in zip((lines.front, lines.back), lines.middles, strict=True)
    )
    return NecklineFits(
        _rank(lines.front, Neckline.BOAT, front, settings), _rank(lines.back, Neckline.CREW, back, settings)
    )


@dataclass(frozen=True)
class _Turns:
    """Describe the turns of a contour within its surface [rad]: in the middle, and at the lesser of two corners (NaN,
    unknown, where the contour is bridged there)."""

    middle: float
    corner: float


@dataclass(frozen=True)
class _Rim:
    """Describe a neck contour within its surface: its vertices [m], shape [n, 3]; the turn at each within the surface,
    positive in a V [rad], shape [n]; and whether the segment to each from the one before is no border of the surface,
    shape [n]."""

    points: np.ndarray
    turns: np.ndarray
    bridged: np.ndarray

    @classmethod
    def of(cls, target: Target, contour: Contour, settings: NecklineSettings) -> _Rim:
        """Compute the rim of a target's contour."""
        loop = contour.vertices
        edges = HalfEdges.of(target.faces, len(target.vertices))
        along = {*zip(edges.tail[edges.border].tolist(), edges.head[edges.border].tolist(), strict=True)}
        bridged = np.array([(int(a), int(b)) not in along for a, b in zip(np.roll(loop, 1), loop, strict=True)])
        turns = -rim_turns(target.vertices[target.faces], target.faces, loop)
        return cls(target.vertices[loop], turns - _curvature_beside(target, loop, settings.strip_width), bridged)

    def turns_around(self, middle: np.ndarray, length: float, settings: NecklineSettings) -> _Turns | None:
        """Sum the turns around the middle of the front or back [m], shape [3], and at the corners; None where it is
        bridged. `length` is that from the middle to the side neck point [m]."""
        nearest = int(np.linalg.norm(self.points - middle, axis=1).argmin())
        points, turns, bridged = (np.roll(each, -nearest, axis=0) for each in (self.points, self.turns, self.bridged))
        arc = Curve(points).arc
        at, whole = arc[:-1], arc[-1]
        if bridged[np.minimum(at, whole - at) < 2.0 * settings.turn_std].any():
            return None
        apart = np.abs(at[:, None] - at)
        summed = np.exp(-0.5 * (np.minimum(apart, whole - apart) / settings.turn_std) ** 2) @ turns
        inner, outer = (share * length for share in settings.square_corners)
        sides = [(inner < distance) & (distance < outer) for distance in (at, whole - at)]
        seen = not any(bridged[side].any() for side in sides)
        corner = min(float(summed[side].max(initial=0.0)) for side in sides) if seen else np.nan
        return _Turns(float(summed[0]), corner)


def _curvature_beside(target: Target, loop: np.ndarray, width: float) -> np.ndarray:
    """Sum the curvature of a contour's strip of some width [m] at each of its vertices [rad], shape [n]. By the theorem
    of Gauss and Bonnet a line along the strip's inner side turns by this much more than the contour: dents and rounding
    of a scan's edge turn the contour one way and the strip the other."""
    distance, nearest = cKDTree(target.vertices[loop]).query(target.vertices, distance_upper_bound=width)
    inside = np.isfinite(distance)
    curvature = angle_defects(target.vertices, target.faces)
    return np.bincount(nearest[inside], curvature[inside], minlength=len(loop))


def _rank(
    line: np.ndarray, shallow: Neckline, turns: _Turns | None, settings: NecklineSettings
) -> tuple[NecklineFit, ...]:
    """Rank the necklines by their misfit; round first unless another one is clearly better, or has its corners. A
    square needs its corners within the cloth, since a round neckline may be crumpled on the shoulders. `shallow` is the
    name of a shallow round one: a boat in front, where it is cut into the shoulders. `turns` are those of the contour
    within the cloth, or None."""
    half_width, depth = float(line[0, 0]), float(line[-1, 1])
    ratio, kind = depth / half_width, Neckline.CREW
    if ratio < settings.boat_depth:
        kind = shallow
    elif ratio > settings.scoop_depth:
        kind = Neckline.SCOOP
    fits = [rounded := _fit(line, NecklineCut(kind, depth)), square := _fit(line, NecklineCut(Neckline.SQUARE, depth))]
    pointed = min(
        (_fit(line, NecklineCut(Neckline.V, depth, bow)) for bow in settings.v_bows), key=lambda fit: fit.misfit
    )
    corner = corner_turn(pointed.neckline, half_width)
    by_turns = _classify_by_turns(turns, rounded, square, pointed, settings)
    if by_turns is pointed or (
        corner > settings.v_turn
        and (turns is None or turns.middle > max(settings.v_turn, settings.v_turn_share * corner))
    ):
        fits.append(pointed)
    clear = settings.clear_misfit * rounded.misfit

    def rank(fit: NecklineFit) -> tuple[bool, bool, float]:
        unclear = fit is square and (
            depth <= settings.square_depth or (turns is not None and turns.corner < settings.square_turn)
        )
        return fit is not by_turns, fit is not rounded and (fit.misfit >= clear or unclear), fit.misfit

    return tuple(sorted(fits, key=rank))


def _classify_by_turns(
    turns: _Turns | None, rounded: NecklineFit, square: NecklineFit, pointed: NecklineFit, settings: NecklineSettings
) -> NecklineFit | None:
    """Return the line with clear corners within the cloth, even if it hangs nearly round; None where there is none."""
    if turns is None:
        return None
    cornered = (
        turns.corner > max(settings.square_turn, settings.turn_ratio * turns.middle)
        and square.neckline.depth > settings.square_depth
    )
    if cornered and square.misfit < settings.square_misfit * rounded.misfit:
        return square
    if (
        turns.middle > max(settings.surface_v_turn, settings.turn_ratio * turns.corner)
        and pointed.misfit < settings.v_misfit * rounded.misfit
    ):
        return pointed
    return None


def _fit(line: np.ndarray, neckline: NecklineCut) -> NecklineFit:
    """Return the fit of a drafted neckline of a line's width and depth, by distances in both directions."""
    half_width = float(line[0, 0])
    drawn, seen = neckline_points(neckline, half_width), line * (1.0, -1.0)
    gaps = np.concatenate([cKDTree(drawn).query(seen)[0], cKDTree(seen).query(drawn)[0]])
    return NecklineFit(neckline, half_width, float(np.sqrt((gaps**2).mean())) / half_width)
