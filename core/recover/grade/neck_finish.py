"""Choose collar, hood and front of a garment by the cloth at its neck, compared with that of draped ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache
from pathlib import Path

import numpy as np

from ...garment.parts.cut import Collar, Cut, Front, Hood, HoodWorn, Neckline, PartsConflict, Shaping
from ...garment.parts.draft import draft_cut
from .neck_shape import NeckShape

MIN_SLIT_LENGTH = 0.03
"""Length from which two edges beside each other are a placket [m]: its first button is 2 cm below the neck. The lowest
point of a V is less than a placket's overlap wide over 2.5 cm; the border of a closed shirt ends 2 cm below its
fall."""

RARE_COST = 2.0
"""Misfit of a strip that stands upright, of a hood, and of a front that a collar is not usually cut with [standard
deviations]: one garment in seven, exp(-2)."""

POOLED_DRAPE_COUNT = 7.0
"""Number of drapes of a style that the covariance of all styles counts as [1], and"""

DIAGONAL_SHARE = 0.5
"""share of the diagonal in the covariance of the measures [1]: a hundred drapes do not show how each style varies
(regularised discriminant analysis, J. H. Friedman 1989). Both, and the exponent, are those at which leaving each drape
out in turn its style is likeliest."""

DENSITY_EXPONENT = 0.5
"""Power of a density that counts [1]: other bodies, cloth and scanners differ more than drapes that are compared."""

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

DRAPES = Path(__file__).with_name("neck_drapes.npz")
"""What is measured at the necks of draped tops, by `<kind>/<sides>`; written by `training/necks.py`."""


class ShownSides(StrEnum):
    """Describe what a scan shows of cloth: both sides, of a garment that was scanned by itself, or the outside, of one
    that a scanned person wears."""

    BOTH = "both"
    OUTSIDE = "outside"


class NeckStyle(StrEnum):
    """Describe what is sewn to a neck by what a scan can show of it."""

    PLAIN = "plain"
    STAND = "stand"
    TURTLENECK = "turtleneck"
    FALL = "fall"
    LAPELS = "lapels"
    SHAWL = "shawl"
    HOOD_UP = "hood-up"
    HOOD_DOWN = "hood-down"


STYLE_COLLARS: Mapping[NeckStyle, tuple[Collar, ...]] = {
    NeckStyle.PLAIN: (Collar.NONE, Collar.RIB),
    NeckStyle.STAND: (Collar.STAND,),
    NeckStyle.TURTLENECK: (Collar.TURTLENECK,),
    NeckStyle.FALL: (Collar.SHIRT, Collar.CONVERTIBLE, Collar.POLO),
    NeckStyle.LAPELS: (Collar.NOTCHED,),
    NeckStyle.SHAWL: (Collar.SHAWL,),
    NeckStyle.HOOD_UP: (Collar.NONE,),
    NeckStyle.HOOD_DOWN: (Collar.NONE,),
}
"""Collars of each style: those with a fall differ in what is hidden below it. A rib lies as the garment's own cloth."""

RARE_STYLES = (NeckStyle.STAND, NeckStyle.TURTLENECK, NeckStyle.HOOD_UP, NeckStyle.HOOD_DOWN)
"""Strips that stand upright, and hoods."""

STYLE_HOODS: Mapping[NeckStyle, HoodWorn] = {NeckStyle.HOOD_UP: HoodWorn.UP, NeckStyle.HOOD_DOWN: HoodWorn.DOWN}
"""How a hood is worn."""


@dataclass(frozen=True)
class NeckKind:
    """Describe what a scan can show at a neck.

    Attributes:
        style: What is sewn to it.
        neckline: Of a plain neck; else a crew neck.
        is_open: Whether the front is open.
    """

    style: NeckStyle = NeckStyle.PLAIN
    neckline: Neckline = Neckline.CREW
    is_open: bool = False

    @property
    def name(self) -> str:
        """Return its name, as in the file of drapes."""
        return f"{self.style}-{self.neckline}-{'open' if self.is_open else 'closed'}"


NECK_KINDS: tuple[NeckKind, ...] = (
    *(NeckKind(neckline=neckline) for neckline in Neckline),
    *(NeckKind(neckline=neckline, is_open=True) for neckline in (Neckline.CREW, Neckline.V)),
    *(
        NeckKind(style, is_open=is_open)
        for style in NeckStyle
        if style is not NeckStyle.PLAIN
        for is_open in ((False,) if style is NeckStyle.TURTLENECK else (False, True))
    ),
)
"""Kinds that are told apart."""


@dataclass(frozen=True)
class KindDensity:
    """Describe the normal density of a neck's measures of one kind, seen on one or both sides.

    Attributes:
        kind: The kind.
        sides: The sides of the cloth that are seen.
        mean: Shape [k].
        precision: Inverse covariance, shape [k, k].
        log_scale: Logarithm of the density at the mean, up to a term of all kinds.
    """

    kind: NeckKind
    sides: ShownSides
    mean: np.ndarray
    precision: np.ndarray
    log_scale: float

    def log_density(self, vector: np.ndarray) -> float:
        """Return the logarithm of the density, up to a term of all kinds, of a neck's measures, shape [k]."""
        gap = vector - self.mean
        return float(self.log_scale - 0.5 * gap @ self.precision @ gap)


def fit_densities(samples: Mapping[str, np.ndarray]) -> tuple[KindDensity, ...]:
    """Fit the density of each kind on each side: one covariance C for a style, for the mean of n drapes C (1 + 1 / n).

    Args:
        samples: Measures of drapes, shape [n, k], by `<kind>/<sides>`.
    """
    kinds, found = {kind.name: kind for kind in NECK_KINDS}, []
    for sides in ShownSides:
        seen = {kinds[name.split("/")[0]]: rows for name, rows in samples.items() if name.endswith(sides)}
        covariances = _fit_covariances(seen)
        for kind, rows in seen.items():
            covariance = (1.0 + 1.0 / len(rows)) * covariances[kind.style]
            scale = -0.5 * float(np.linalg.slogdet(covariance)[1])
            found.append(KindDensity(kind, sides, rows.mean(axis=0), np.linalg.inv(covariance), scale))
    return tuple(found)


def _fit_covariances(seen: Mapping[NeckKind, np.ndarray]) -> dict[NeckStyle, np.ndarray]:
    """Return the covariance of each style, shape [k, k] each, about the means of its kinds."""
    off: dict[NeckStyle, list[np.ndarray]] = {}
    for kind, rows in seen.items():
        off.setdefault(kind.style, []).append(rows - rows.mean(axis=0))
    scatters = {style: sum(rows.T @ rows for rows in every) for style, every in off.items()}
    counts = {style: sum(len(rows) - 1 for rows in every) for style, every in off.items()}
    pooled = np.sum(list(scatters.values()), axis=0) / sum(counts.values())
    found = {}
    for style, scatter in scatters.items():
        covariance = (scatter + POOLED_DRAPE_COUNT * pooled) / (counts[style] + POOLED_DRAPE_COUNT)
        found[style] = (1.0 - DIAGONAL_SHARE) * covariance + DIAGONAL_SHARE * np.diag(np.diag(covariance))
    return found


@cache
def load_densities() -> tuple[KindDensity, ...]:
    """Return the densities of the drapes that ship."""
    with np.load(DRAPES) as stored:
        return fit_densities({name: stored[name].astype(np.float64) for name in stored.files})


@dataclass(frozen=True)
class NeckFinish:
    """Describe a collar, or a hood and how it is worn, and a front.

    Attributes:
        collar, front, hood, hood_worn: The parts.
        misfit: By which it is less likely than the likeliest [standard deviations].
        probability: Of what a scan can show of it, its style, among those that the user left.
    """

    collar: Collar
    front: Front
    hood: Hood = Hood.NONE
    hood_worn: HoodWorn = HoodWorn.DOWN
    misfit: float = 0.0
    probability: float = 1.0

    def apply(self, cut: Cut) -> Cut:
        """Return a cut with them; collars and hoods are sewn to a crew neck, and the edges of a wrap make a V."""
        cut = replace(cut, collar=self.collar, front=self.front, hood=self.hood, hood_worn=self.hood_worn)
        if self.front is Front.WRAP:
            return replace(cut, neckline=Neckline.V, neck_depth=None, shaping=Shaping.NONE)
        if self.collar is Collar.NONE and self.hood is Hood.NONE:
            return cut
        return replace(cut, neckline=Neckline.CREW, back_neckline=Neckline.CREW)

    def drafts_on(self, cut: Cut) -> bool:
        """Check whether it is drafted on a cut."""
        try:
            draft_cut(self.apply(cut))
        except PartsConflict:
            return False
        return True


def rank_finishes(
    shape: NeckShape, cut: Cut, fixed: Mapping[str, str], sides: ShownSides = ShownSides.BOTH
) -> tuple[NeckFinish, ...]:
    """Rank collars, hoods and fronts by the likelihood of a scan's neck, best first.

    The density of a style at the scan's measures is that of the drapes of its kind in which it is largest; a garment
    that was scanned by itself rarely shows its outside alone. An open front and a slit are seen; which of the closed
    fronts it is, is not, and the usual one for the collar is taken. A rib, and a strip between the sides of a hood, are
    only the user's choice. Those that are less likely than the first by more than `RARE_COST` are left out.

    Args:
        shape: Of the scan's neck.
        cut: That they are drafted on.
        fixed: Choices of the user, by part.
        sides: The sides that the scan shows.
    """
    squares, styles = _measure_styles(shape, sides), dict[NeckStyle, float]()
    weighed = []
    for style, finish in _list_finishes(shape, fixed):
        is_shown = finish.front is not Front.PLACKET or shape.slit > MIN_SLIT_LENGTH
        is_rare = style in RARE_STYLES, finish.front not in USUAL_FRONTS[finish.collar] or not is_shown
        square = squares.get(style, max(squares.values())) + RARE_COST**2 * sum(is_rare)
        styles[style] = min(square, styles.get(style, np.inf))
        weighed.append((square, style, finish))
    weighed.sort(key=lambda one: one[0])
    found: list[NeckFinish] = []
    least = np.inf
    for square, style, finish in weighed:
        if square <= least + RARE_COST**2 and finish.drafts_on(cut):
            least = min(least, square)
            share = sum(np.exp(0.5 * (styles[style] - other)) for other in styles.values())
            found.append(replace(finish, misfit=float(np.sqrt(square - least)), probability=float(1.0 / share)))
    return tuple(found)


def _measure_styles(shape: NeckShape, sides: ShownSides) -> dict[NeckStyle, float]:
    """Return the squared misfit of each style, -2 times the logarithm of its density, up to a term of all styles."""
    vector = shape.to_vector()
    found: dict[NeckStyle, float] = {}
    for density in load_densities():
        if density.kind.is_open == shape.is_open and (sides is ShownSides.BOTH or density.sides is sides):
            square = -2.0 * DENSITY_EXPONENT * density.log_density(vector)
            square += RARE_COST**2 * (density.sides is not sides)
            found[density.kind.style] = min(square, found.get(density.kind.style, np.inf))
    return found


def _list_finishes(shape: NeckShape, fixed: Mapping[str, str]) -> list[tuple[NeckStyle, NeckFinish]]:
    """Return the finishes that the user's choices leave, each with the front that the scan shows or is usual."""

    def front(collar: Collar) -> Front:
        return Front(fixed["front"]) if "front" in fixed else _choose_front(shape, collar)

    is_round = {fixed.get(part, "crew") for part in ("neckline", "back_neckline")} == {"crew"}
    chosen = fixed.get("collar", None if is_round else "none")
    found = []
    for style, collars in STYLE_COLLARS.items():
        worn = STYLE_HOODS.get(style)
        if worn is None and fixed.get("hood", "none") == "none":
            named = [one for one in collars if (one is not Collar.RIB if chosen is None else one == chosen)]
            found += [(style, NeckFinish(collar, front(collar))) for collar in named]
        elif worn is not None and chosen is None and fixed.get("hood_worn", worn) == worn:
            hood = Hood(fixed.get("hood", Hood.TWO))
            if hood is not Hood.NONE:
                found.append((style, NeckFinish(Collar.NONE, front(Collar.NONE), hood, worn)))
    return found


def _choose_front(shape: NeckShape, collar: Collar) -> Front:
    """Return the front that a scan shows, or the usual closed one for a collar."""
    if shape.is_open:
        return Front.OPEN
    if shape.slit > MIN_SLIT_LENGTH:
        return Front.PLACKET
    return next(front for front in USUAL_FRONTS[collar] if front is not Front.OPEN)
