"""Add a wrapped front to the fronts that a garment may have, by the lap that its scan shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...garment.neckline_fit import NecklineFit, NecklineFits
from ...garment.parts.cut import Collar, Cut, Front, Hood, Neckline
from .lap import Lap
from .neck_finish import RARE_COST, NeckFinish

PLAIN_FRONTS = (Front.NONE, Front.PLACKET)
"""Fronts that a wrap is told from: the point of its V may look like the slit of a placket."""

WRAPPED_NECKLINES = (Neckline.V, Neckline.SCOOP, Neckline.CREW)
"""What the neckline of a wrap looks like on a scan: a V, whose point a coarse surface rounds."""


def add_wrap(
    finishes: Sequence[NeckFinish], lap: Lap | None, fits: NecklineFits | None, cut: Cut, fixed: Mapping[str, str]
) -> tuple[NeckFinish, ...]:
    """Add a wrap to the finishes of a neck, best first.

    A wrap is the same at the neck as the likeliest finish without collar and hood. Beside that, it has the likelihood
    of its lap, and is rare: its squared misfit is that of the plain one, plus `RARE_COST`^2, less twice the logarithm
    of the ratio of likelihoods. Both share the probability of a plain neck. A lap without doubt leaves
    nothing else.

    Args:
        finishes: Of `rank_finishes`.
        lap: Of the scan; None where nothing tells of one.
        fits: Of its necklines; None where they are not compared.
        cut: That it is drafted on.
        fixed: Choices of the user, by part.
    """
    if lap is None or not _may_wrap(fixed):
        return tuple(finishes)
    is_certain = bool(np.isposinf(lap.log_odds))
    plain = next(
        (one for one in finishes if _is_plain(one)), NeckFinish(Collar.NONE, Front.NONE) if is_certain else None
    )
    if plain is None or not (is_certain or fits is None or fits.front[0].neckline.kind in WRAPPED_NECKLINES):
        return tuple(finishes)
    wrap = replace(plain, front=Front.WRAP)
    if not wrap.drafts_on(cut):
        return tuple(finishes)
    if is_certain:
        return (replace(wrap, misfit=0.0, probability=1.0),)
    odds = lap.log_odds - 0.5 * RARE_COST**2
    share = float(1.0 / (1.0 + np.exp(-odds)))
    squares = [(one, one.misfit**2) for one in finishes]
    weighed = [
        (replace(one, probability=(1.0 - share) * one.probability) if _is_plain(one) else one, square)
        for one, square in squares
    ]
    weighed.append((replace(wrap, probability=share * plain.probability), plain.misfit**2 - 2.0 * odds))
    least = min(square for _, square in weighed)
    kept = [(one, square - least) for one, square in weighed if square - least <= RARE_COST**2]
    kept.sort(key=lambda pair: pair[1])
    return tuple(replace(one, misfit=float(np.sqrt(square))) for one, square in kept)


def unwrap(finishes: Sequence[NeckFinish]) -> tuple[NeckFinish, ...]:
    """Return finishes with plain fronts for wraps, by which girths are compared: two layers count once."""
    return tuple(replace(one, front=Front.NONE) if one.front is Front.WRAP else one for one in finishes)


def draw_wrapped_necklines(fits: NecklineFits) -> NecklineFits:
    """Return the fits of a wrap's neckline: in front a V of the depth that is seen."""
    front = next((one for one in fits.front if one.neckline.kind is Neckline.V), fits.front[0])
    vee = NecklineFit(replace(front.neckline, kind=Neckline.V), front.half_width, front.misfit)
    return replace(fits, front=(vee,))


def _is_plain(finish: NeckFinish) -> bool:
    """Check whether a finish has neither collar nor hood, and a front that a wrap is told from."""
    return finish.collar is Collar.NONE and finish.hood is Hood.NONE and finish.front in PLAIN_FRONTS


def _may_wrap(fixed: Mapping[str, str]) -> bool:
    """Check whether the user's choices leave a wrap."""
    usual = {"neckline": "v", "collar": "none", "hood": "none", "shaping": "none"}
    if "front" in fixed or any(fixed.get(part, word) != word for part, word in usual.items()):
        return False
    return fixed.get("sleeve_head") != "raglan"
