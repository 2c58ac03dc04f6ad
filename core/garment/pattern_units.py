"""Check that a pattern has the size of a garment in the unit that its file claims."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..run.units import UNITS
from .errors import PatternUnitsUnclear
from .pattern import Panel

UNITS_KEY, CONFIRMED_KEY = "units_in_meter", "units_confirmed"
"""Keys of a file's properties: units per metre, and whether a person has said that they are right."""

MIN_LARGEST_PANEL, MAX_LARGEST_PANEL = 0.25, 3.0
"""Range of the longer side of a garment's largest panel [m]: from the front of a baby's shirt to a long gown with a
train."""

USUAL_LARGEST_PANEL = (0.35, 2.0)
"""Usual range of it [m], in which another unit has to bring it to be asked about: crop top to evening dress."""


def check_pattern_units(panels: Sequence[Panel], properties: dict[str, Any]) -> None:
    """Check the size of a pattern from elsewhere.

    Args:
        panels: As the file's unit has them [m].
        properties: Of the file.

    Raises:
        PatternUnitsUnclear: where no panel is as large as a garment's, or one is larger, and in another unit they are
            usual; the message names these units.
    """
    if properties.get(CONFIRMED_KEY) is True:
        return
    largest = max(float(np.ptp(panel.points, axis=0).max()) for panel in panels)
    if MIN_LARGEST_PANEL <= largest <= MAX_LARGEST_PANEL:
        return
    per_metre = float(properties[UNITS_KEY])
    low, high = USUAL_LARGEST_PANEL
    usual = {name: largest * per_metre * length for name, length in UNITS.items()}
    likely = {name: size for name, size in usual.items() if low <= size <= high}
    if likely:
        readings = ", ".join(f"{100.0 * size:.0f} cm with --units {name}" for name, size in likely.items())
        raise PatternUnitsUnclear(
            f"the pattern's largest panel is {100.0 * largest:.3g} cm in its file's unit ({per_metre:g} in a metre), "
            f"but {readings}; say the unit: garmentq templates import FILE --name NAME --units UNIT."
        )


def set_units(document: dict[str, Any], units: str) -> dict[str, Any]:
    """Return the JSON document of a pattern with a unit of `UNITS` that a person has said; its numbers stay.

    Args:
        document: As read; it is not changed.
        units: Name of the unit.
    """
    properties = document.get("properties")
    known = properties if isinstance(properties, dict) else {}
    return {**document, "properties": {**known, UNITS_KEY: 1.0 / UNITS[units], CONFIRMED_KEY: True}}
