"""How sure the place and the length of each line of a recovered pattern are: intervals by kind of line and by what
shows it, from garments whose patterns are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..garment.pattern import Pattern
from ..garment.pieces.pattern_lines import PatternLine
from ..run.units import MM_PER_M
from ..run.verdict import Gate, Verdict
from .gates import Product, product_of

INTERVAL_COVERAGE = 0.9
"""Share of lines whose true place, and whose true length, lies within the interval [1]."""

POOLED_LINE_COUNT = 4.0
"""Number of lines of a kind that the median error of all kinds counts as [1]: the median of four scatters by half."""

MIN_ERROR = 1e-4
"""Least error that is told from none [m, and 1 of a length's logarithm]: a tenth of a millimetre, which paper does not
keep."""

MAX_SEEN_PLACE = 0.015
"""Half width of a place beyond which a line counts as not visible [m]: the seam allowance of most trades, within which
a seam is moved at a fitting without another cut."""

KNOWN_ERRORS = Path(__file__).with_name("line_errors.npz")
"""Errors of recovered lines whose truth is known; written by `benchmarks/line_errors.py`."""


class Evidence(StrEnum):
    """Describe what decides where a line is: an end of the cloth that the scan shows, its curvature, a step of its
    colours, stripes that turn, the proportions of the base pattern, or those alone, where the scan shows none of the
    cloth around it."""

    EDGE = "edge"
    CURVATURE = "curvature"
    COLOUR = "colour"
    STRIPES = "stripes"
    PROPORTION = "proportion"
    HIDDEN = "hidden"


SEEN_ON_CLOTH = (Evidence.COLOUR, Evidence.STRIPES, Evidence.CURVATURE)
"""What shows a seam between two panels."""


@dataclass(frozen=True)
class LineInterval:
    """Describe how sure a line of a pattern is.

    Attributes:
        line: The line.
        evidence: What decides where it is.
        length: On the flat cloth [m].
        place_margin: Half width of its place on the cloth [m], RMS along it; None where nothing shows it.
        length_margin: Half width of its length [m]; None where nothing shows it.
    """

    line: PatternLine
    evidence: Evidence
    length: float
    place_margin: float | None
    length_margin: float | None

    @property
    def is_visible(self) -> bool:
        """Return whether the scan shows where it is."""
        return self.place_margin is not None and self.place_margin <= MAX_SEEN_PLACE

    def describe(self) -> dict[str, str | float | bool | None]:
        """Return the interval as JSON values, lengths in mm."""

        def to_mm(value: float | None) -> float | None:
            return None if value is None else round(MM_PER_M * value, 1)

        return {
            "name": self.line.name,
            "side": self.line.side,
            "evidence": str(self.evidence),
            "visible": self.is_visible,
            "place_margin_mm": to_mm(self.place_margin),
            "length_mm": to_mm(self.length),
            "length_margin_mm": to_mm(self.length_margin),
        }


def describe_margins(entry: Mapping[str, Any]) -> tuple[str, str, str]:
    """Return a line of a manifest as words: name and side, `45.2 cm +-0.9`, and what is known of its place.

    Args:
        entry: Of `LineInterval.describe`.
    """
    name = " ".join(filter(None, (str(entry.get("name")), str(entry.get("side") or ""))))
    length, margin, place = (entry.get(f"{key}_mm") for key in ("length", "length_margin", "place_margin"))
    measured = f"{length / 10.0:.1f} cm" + ("" if margin is None else f" +-{margin / 10.0:.1f}") if length else ""
    if place is None:
        return name, measured, "not scanned: the base pattern's"
    return name, measured, ("" if entry.get("visible") else "place not visible, ") + f"+-{place:.0f} mm"


@dataclass(frozen=True)
class Margins:
    """Describe the margins of one kind of line with one evidence: of its place [m], of its length's logarithm [1]."""

    place: float
    length: float


@cache
def load_margins() -> Mapping[tuple[str, Evidence], Margins]:
    """Return the margins by kind of line and evidence from the known errors that ship."""
    with np.load(KNOWN_ERRORS) as stored:
        words = zip(stored["name"], stored["evidence"], strict=True)
        kinds = [(str(name), Evidence(str(word))) for name, word in words]
        return fit_margins(kinds, stored["place"].astype(float), stored["length"].astype(float))


def fit_margins(
    kinds: Sequence[tuple[str, Evidence]], places: np.ndarray, lengths: np.ndarray
) -> dict[tuple[str, Evidence], Margins]:
    """Fit the margins of each kind of line with each evidence, and by an empty name those of kinds that are not known.

    An error is measured by its kind's median, m_k, which `POOLED_LINE_COUNT` lines draw to that of all kinds. Of the n
    ratios e / m_k of all kinds with one evidence the one of rank (n + 1) `INTERVAL_COVERAGE`, rounded up, times m_k is
    the margin (split conformal prediction with normalised scores, V. Vovk et al. 2005, H. Papadopoulos et al. 2002).

    Args:
        kinds: Name and evidence of each known line.
        places: Errors of their places [m], shape [n].
        lengths: Absolute logarithms of ratios of their lengths, shape [n].
    """
    found: dict[tuple[str, Evidence], Margins] = {}
    for evidence in sorted({word for _, word in kinds}):
        own = [n for n, (_, word) in enumerate(kinds) if word == evidence]
        names = [kinds[n][0] for n in own]
        fitted = [_fit_margins(names, np.log(np.maximum(all_[own], MIN_ERROR))) for all_ in (places, lengths)]
        found |= {(name, evidence): Margins(fitted[0][name], fitted[1][name]) for name in ("", *names)}
    return found


def _fit_margins(names: Sequence[str], errors: np.ndarray) -> dict[str, float]:
    """Return the margin of each kind, given the logarithms of the errors of lines by name, shape [n]."""
    common = float(np.median(errors))
    medians = {"": common}
    for name in set(names):
        own = errors[[one == name for one in names]]
        share = len(own) / (len(own) + POOLED_LINE_COUNT)
        medians[name] = share * float(np.median(own)) + (1.0 - share) * common
    scores = np.sort(errors - [medians[name] for name in names])
    rank = min(int(np.ceil((len(scores) + 1) * INTERVAL_COVERAGE)), len(scores)) - 1
    return {name: float(np.exp(median + scores[rank])) for name, median in medians.items()}


def has_sure_lines(gates: Sequence[Gate]) -> bool:
    """Check whether intervals hold for a result: where its detail mesh or its pattern fails, they do not."""
    return not any(gate.verdict == Verdict.FAIL and product_of(gate.name) is not Product.DRAPE for gate in gates)


def find_margins(name: str, evidence: Evidence, known: Mapping[tuple[str, Evidence], Margins]) -> Margins | None:
    """Return the margins of a line; None where nothing shows it. Where no errors of a line seen by its colours or
    stripes are known, they are those of one that is placed by proportions, which are wider.

    Args:
        name: Of the line.
        evidence: What decides where it is.
        known: Margins by kind and evidence.
    """
    tried = [evidence, *([Evidence.PROPORTION] if evidence in SEEN_ON_CLOTH else [])]
    kinds = [] if evidence is Evidence.HIDDEN else [(one, word) for word in tried for one in (name, "")]
    return next((known[kind] for kind in kinds if kind in known), None)


def measure_intervals(pattern: Pattern, lines: Sequence[tuple[PatternLine, Evidence]]) -> tuple[LineInterval, ...]:
    """Return the intervals of a pattern's lines; a length's grows with the length.

    Args:
        pattern: The recovered pattern.
        lines: Its lines, and what shows each.
    """
    found = []
    for line, evidence in lines:
        length, known = line.measure_length(pattern), find_margins(line.name, evidence, load_margins())
        place, margin = (None, None) if known is None else (known.place, length * float(np.expm1(known.length)))
        found.append(LineInterval(line, evidence, length, place, margin))
    return tuple(found)
