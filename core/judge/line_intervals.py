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

MIN_LINE_COUNT = 12
"""Number of known lines of one kind from which its own errors give the interval [1]: of eleven, the largest error is
that which 90 % of further ones stay below (the rank (n + 1) 0.9 of n errors must exist)."""

MAX_SEEN_PLACE = 0.015
"""Half width of a place beyond which a line counts as not visible [m]: the seam allowance of most trades, within which
a seam is moved at a fitting without another cut."""

KNOWN_ERRORS = Path(__file__).with_name("line_errors.npz")
"""Errors of recovered lines whose truth is known; written by `benchmarks/line_errors.py`."""


class Evidence(StrEnum):
    """Describe what decides where a line is: an end of the cloth that the scan shows, its curvature, its colours, the
    proportions of the base pattern, or those alone, where the scan shows none of the cloth around it."""

    EDGE = "edge"
    CURVATURE = "curvature"
    COLOUR = "colour"
    PROPORTION = "proportion"
    HIDDEN = "hidden"


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
class KnownErrors:
    """Describe errors of recovered lines of one kind, or of all that have one evidence.

    Attributes:
        places: RMS distances of the true line from the recovered one on the cloth [m], shape [n].
        lengths: Absolute logarithms of the ratio of its lengths, shape [n].
    """

    places: np.ndarray
    lengths: np.ndarray

    @property
    def margins(self) -> tuple[float, float]:
        """Return the errors of place [m] and of length [1] that `INTERVAL_COVERAGE` of further lines stay below: of n
        errors the one of rank (n + 1) `INTERVAL_COVERAGE`, rounded up (conformal prediction, V. Vovk 2005)."""
        rank = min(int(np.ceil((len(self.places) + 1) * INTERVAL_COVERAGE)), len(self.places)) - 1
        return float(np.sort(self.places)[rank]), float(np.sort(self.lengths)[rank])


@cache
def load_errors() -> Mapping[tuple[str, Evidence], KnownErrors]:
    """Return the known errors that ship by kind of line and evidence; those of all kinds by an empty name."""
    with np.load(KNOWN_ERRORS) as stored:
        kinds = [
            (str(name), Evidence(str(word))) for name, word in zip(stored["name"], stored["evidence"], strict=True)
        ]
        return group_errors(kinds, stored["place"].astype(float), stored["length"].astype(float))


def group_errors(
    kinds: Sequence[tuple[str, Evidence]], places: np.ndarray, lengths: np.ndarray
) -> dict[tuple[str, Evidence], KnownErrors]:
    """Group errors by kind of line and evidence, and by evidence alone.

    Args:
        kinds: Name and evidence of each line.
        places: Errors of their places [m], shape [n].
        lengths: Absolute logarithms of ratios of their lengths, shape [n].
    """
    rows: dict[tuple[str, Evidence], list[int]] = {}
    for n, (name, evidence) in enumerate(kinds):
        rows.setdefault((name, evidence), []).append(n)
        rows.setdefault(("", evidence), []).append(n)
    return {kind: KnownErrors(places[own], lengths[own]) for kind, own in rows.items()}


def has_sure_lines(gates: Sequence[Gate]) -> bool:
    """Check whether intervals hold for a result: where its detail mesh or its pattern fails, they do not."""
    return not any(gate.verdict == Verdict.FAIL and product_of(gate.name) is not Product.DRAPE for gate in gates)


def find_margins(
    name: str, evidence: Evidence, known: Mapping[tuple[str, Evidence], KnownErrors]
) -> tuple[float | None, float | None]:
    """Return the margins of the place [m] and of a length's logarithm [1] of a line; None where nothing shows it.

    Those of a kind with fewer than `MIN_LINE_COUNT` known lines are those of all kinds with its evidence, or its own
    largest errors where these are larger.

    Args:
        name: Of the line.
        evidence: What decides where it is.
        known: Errors by kind and evidence.
    """
    own, every = known.get((name, evidence)), known.get(("", evidence))
    if evidence is Evidence.HIDDEN or every is None:
        return None, None
    if own is not None and len(own.places) >= MIN_LINE_COUNT:
        return own.margins
    place, length = every.margins
    return (place, length) if own is None else (max(place, own.places.max()), max(length, own.lengths.max()))


def measure_intervals(pattern: Pattern, lines: Sequence[tuple[PatternLine, Evidence]]) -> tuple[LineInterval, ...]:
    """Return the intervals of a pattern's lines; a length's grows with the length.

    Args:
        pattern: The recovered pattern.
        lines: Its lines, and what shows each.
    """
    found = []
    for line, evidence in lines:
        length, (place, ratio) = line.measure_length(pattern), find_margins(line.name, evidence, load_errors())
        margin = None if ratio is None else length * float(np.expm1(ratio))
        found.append(LineInterval(line, evidence, length, place, margin))
    return tuple(found)
