"""Find a scan's neckline, in front and behind, by the shape of its contour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..body import Body
from ..mesh import ClosedCurve, HalfEdges, rim_turns
from ..pattern.parts import Neckline, Throat, corner_turn, neckline_points
from ..segment import Contour, Target, unroll_neck

CORNER = np.radians(45.0)
"""Least turn in the middle that makes a V. The shallowest that is worn, 12 cm deep and 30 cm wide, turns by 77 degrees;
round necklines of scans, taken for Vs with bowed sides, by up to 37."""

AROUND = 0.02
"""Standard deviation of the window over which a contour's turn in the middle is summed [m]: two edges of a scan's mesh,
two teeth of a cut along triangles."""

IN_CLOTH = 0.5
"""Least turn of a contour within its surface by that of the V: 0.95 to 1.06 of it on V-necks of five drapes, 0.3 where
folds drew a round one together behind."""

CLEAR = 0.6
"""A line other than a round one is chosen where its misfit is below this share of the round one's: round is what most
necklines are. V-necks of three scans have 0.08 to 0.22 of it, the crew necks of two 1.6 and more."""

BOWS = np.round(np.arange(-0.15, 0.151, 0.0125), 4)
"""Bows of a V's side that are tried; 0.15 is a quarter turn from one end to the other, and no V any more."""

SCOOP = 1.35
"""A round neckline is a scoop where it is deeper than this many half widths: halfway from the crew's to the scoop's."""


BOAT = 0.6
"""A round neckline is a boat where it is less deep than this many half widths; usually a boat has 0.3, a crew 1.1."""


@dataclass(frozen=True)
class NecklineFit:
    """Describe how well one neckline fits a contour.

    Attributes:
        throat: The neckline, of the contour's depth and bow.
        half_width: The contour's half width [m].
        misfit: Root mean square distance of the two lines, by the half width.
    """

    throat: Throat
    half_width: float
    misfit: float


@dataclass(frozen=True)
class NecklineFits:
    """Describe the fits of all necklines to a scan's contour, in front and behind, best first."""

    front: tuple[NecklineFit, ...]
    back: tuple[NecklineFit, ...]


def fit_necklines(target: Target, body: Body) -> NecklineFits | None:
    """Fit every neckline to a target's neck contour; None where it has none to be trusted, or it cannot be unrolled.

    What hangs in folds may come to a point that was cut round, so a V has to turn within the cloth, too: by the angles
    of the faces around the contour's vertices, which folds do not change.
    """
    contour = target.contour("neck")
    if contour is None or not contour.trusted:
        return None
    lines = unroll_neck(target.vertices[contour.vertices], body)
    if lines is None:
        return None
    front, back = (_turn_in_cloth(target, contour, middle) for middle in lines.middles)
    return NecklineFits(_rank(lines.front, Neckline.BOAT, front), _rank(lines.back, Neckline.CREW, back))


def _turn_in_cloth(target: Target, contour: Contour, middle: np.ndarray) -> float | None:
    """Sum a contour's turn within its surface around a point [rad], positive in a V; None where it is bridged there."""
    loop = contour.vertices
    points = target.vertices[loop]
    nearest = int(np.linalg.norm(points - middle, axis=1).argmin())
    loop = np.roll(loop, -nearest)
    arc = ClosedCurve(target.vertices[loop]).arc
    away = np.minimum(arc[:-1], arc[-1] - arc[:-1])
    edges = HalfEdges.of(target.faces, len(target.vertices))
    along = {*zip(edges.tail[edges.border].tolist(), edges.head[edges.border].tolist(), strict=True)}
    near = np.flatnonzero(away < 2.0 * AROUND)
    if any((int(loop[i - 1]), int(loop[i])) not in along for i in near):
        return None
    turns = rim_turns(target.vertices[target.faces], target.faces, loop)
    return -float(np.exp(-0.5 * (away / AROUND) ** 2) @ turns)


def _rank(line: np.ndarray, shallow: Neckline, turn: float | None) -> tuple[NecklineFit, ...]:
    """Rank the necklines by their misfit; round first unless another one is clearly better.

    `shallow` is what a shallow round one is called: a boat in front, where it has to be cut into the shoulders. `turn`
    is that of the contour in its middle within the cloth, or None.
    """
    half_width, depth = float(line[0, 0]), float(line[-1, 1])
    fits = [
        _fit(line, Throat(name_round(depth / half_width, shallow), depth)),
        _fit(line, Throat(Neckline.SQUARE, depth)),
    ]
    pointed = min((_fit(line, Throat(Neckline.V, depth, float(bow))) for bow in BOWS), key=lambda fit: fit.misfit)
    corner = corner_turn(pointed.throat, half_width)
    if corner > CORNER and (turn is None or turn > IN_CLOTH * corner):
        fits.append(pointed)
    clear = CLEAR * fits[0].misfit
    return tuple(sorted(fits, key=lambda fit: (fit is not fits[0] and fit.misfit >= clear, fit.misfit)))


def name_round(ratio: float, shallow: Neckline = Neckline.BOAT) -> Neckline:
    """Name a round neckline by its depth over its half width."""
    if ratio < BOAT:
        return shallow
    return Neckline.SCOOP if ratio > SCOOP else Neckline.CREW


def _fit(line: np.ndarray, throat: Throat) -> NecklineFit:
    """Compare a line with a drafted neckline of its width and depth, both ways."""
    half_width = float(line[0, 0])
    drawn, seen = neckline_points(throat, half_width), line * (1.0, -1.0)
    gaps = np.concatenate([cKDTree(drawn).query(seen)[0], cKDTree(seen).query(drawn)[0]])
    return NecklineFit(throat, half_width, float(np.sqrt((gaps**2).mean())) / half_width)
