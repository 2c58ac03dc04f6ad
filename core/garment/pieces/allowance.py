"""Seam allowances by the use of an edge."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from ...run.errors import keep_printable
from ...run.text import read_json
from .errors import AllowanceBad
from .piece import EdgeUse

DEFAULT_ALLOWANCES = MappingProxyType({
    EdgeUse.SEAM: 0.010, EdgeUse.GATHERED: 0.010, EdgeUse.DART: 0.0, EdgeUse.NECK: 0.010, EdgeUse.ARMHOLE: 0.010,
    EdgeUse.CUFF: 0.025, EdgeUse.HEM: 0.025, EdgeUse.LEG: 0.040, EdgeUse.WAIST: 0.030, EdgeUse.FRONT: 0.010,
    EdgeUse.ZIP: 0.015, EdgeUse.BUTTONS: 0.030, EdgeUse.VENT: 0.040, EdgeUse.PLACKET: 0.0, EdgeUse.WRAP: 0.010,
    EdgeUse.FACED: 0.010, EdgeUse.OPEN: 0.010, EdgeUse.FOLD: 0.0,
})  # fmt: skip
"""Usual industrial widths [m]: seams and faced or bound edges 1 cm, hems of sleeves and tops 2.5 cm, of trousers 4 cm,
a waist with room for elastic 3 cm, an edge with a zip 1.5 cm. A buttoned edge has a button stand of 2 cm beyond the
centre front, for buttons of 1.5 to 2 cm, and a seam of 1 cm for its facing; so has a cuff. A vent laps by 4 cm. A
sleeve's slit is bound: what its seam takes is drawn already."""

MAX_SEAM_ALLOWANCE = 0.15
"""Largest width of a seam allowance [m]; a wider one has the wrong unit. The deepest usual hem has 10 cm."""

ADJUSTABLE_EDGE_USES = tuple(use for use in EdgeUse if use not in (EdgeUse.DART, EdgeUse.FOLD))
"""Uses of edges whose width can be chosen."""


LENGTH = re.compile(r"(?=[\d.])(?:(\d{1,4})\s+(?=\d+/))?(\d{0,4}(?:\.\d{1,6})?)(?:/(\d{1,3}))?\s*(mm|cm|in|inch|\"|)")
"""A width: a whole number before a fraction, a number or a fraction's upper part, its lower part, the unit."""

UNIT_LENGTHS = MappingProxyType({"": 1e-3, "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "inch": 0.0254, '"': 0.0254})
"""Lengths of the units of a width [m]; a plain number is millimetres."""

MIN_PLAIN_ALLOWANCE = 0.001
"""Smallest width without a unit [m]; a smaller number, 0.625, is rather a part of an inch."""


@dataclass(frozen=True)
class Allowances:
    """Describe the width of the seam allowance of every kind of edge [m]."""

    widths: Mapping[EdgeUse, float] = field(default_factory=lambda: DEFAULT_ALLOWANCES)

    def describe(self) -> str:
        """Return the widths in millimetres as `--allowance` takes them; `none` where all are 0."""
        if not any(self.widths.values()):
            return "none"
        return ",".join(f"{use}={1e3 * self.widths[use]:g}" for use in ADJUSTABLE_EDGE_USES)


def read_allowances(text: str) -> Allowances:
    """Read allowances from an option or from the text of a table.

    Args:
        text: `none`; one width for all edges that have a seam's by default, `15mm`; `seam=10,hem=1in` with the defaults
            for the rest; a JSON object of the same names; or CSV lines `name,width`. A width is `15`, `15mm`, `1.5cm`,
            `5/8in` or `1 1/2in`; a plain number is millimetres. Empty: the defaults.

    Raises:
        AllowanceBad: where a name or a width is invalid, or a plain number is under 1 mm and may be an inch's part.
    """
    stripped = text.strip()
    if stripped == "none":
        return Allowances(MappingProxyType(dict.fromkeys(EdgeUse, 0.0)))
    widths = dict(DEFAULT_ALLOWANCES)
    if LENGTH.fullmatch(stripped):
        seam = _metres(EdgeUse.SEAM, stripped)
        own = (use for use in ADJUSTABLE_EDGE_USES if DEFAULT_ALLOWANCES[use] == DEFAULT_ALLOWANCES[EdgeUse.SEAM])
        return Allowances(MappingProxyType(widths | dict.fromkeys(own, seam)))
    for name, value in _pairs(stripped):
        if name not in ADJUSTABLE_EDGE_USES:
            known = ", ".join(ADJUSTABLE_EDGE_USES)
            raise AllowanceBad(f"'{keep_printable(name[:40])}' is no edge with an allowance; there are {known}.")
        widths[EdgeUse(name)] = _metres(name, value)
    return Allowances(MappingProxyType(widths))


def _pairs(text: str) -> list[tuple[str, str]]:
    if not text:
        return []
    if text.startswith("{"):
        try:
            found = read_json(text)
        except (ValueError, RecursionError) as error:
            raise AllowanceBad from error
        return [(str(name), str(value)) for name, value in found.items()]
    if "=" in text:
        pairs = [one.partition("=") for one in text.replace("\n", ",").split(",") if one.strip()]
        return [(name.strip(), value.strip()) for name, _, value in pairs]
    try:
        rows = [row for row in csv.reader(io.StringIO(text)) if row]
    except csv.Error as error:
        raise AllowanceBad from error
    if any(len(row) != 2 for row in rows):
        raise AllowanceBad
    return [(row[0].strip(), row[1].strip()) for row in rows]


def _metres(name: str, value: str) -> float:
    shown, found, width = keep_printable(value[:20]), LENGTH.fullmatch(value), math.nan
    if found is not None and found[2] and float(found[3] or 1.0) > 0.0:
        width = (float(found[1] or 0.0) + float(found[2]) / float(found[3] or 1.0)) * UNIT_LENGTHS[found[4]]
        if not found[4] and 0.0 < width < MIN_PLAIN_ALLOWANCE:
            raise AllowanceBad(f"the allowance {name}={shown} is under 1 mm; name its unit: {name}={shown}in, or mm.")
    if not 0.0 <= width <= MAX_SEAM_ALLOWANCE:
        raise AllowanceBad(
            f"the allowance {name}={shown} is none; give 0 to {1e3 * MAX_SEAM_ALLOWANCE:.0f} mm, as 15, 15mm or 5/8in."
        )
    return width
