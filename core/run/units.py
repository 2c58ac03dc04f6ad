"""Units of length of files."""

from __future__ import annotations

from typing import Literal

UnitName = Literal["m", "cm", "mm", "inch", "foot"]
"""A name of `UNITS`, for signatures."""

UNITS: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "foot": 0.3048}
"""Metres in one unit, exact (international inch and foot), the usual ones first."""

METRIC = ("m", "cm", "mm")
"""Units that are recognised by a garment's or body's size."""

MM_PER_M = 1e3
"""Number of millimetres in a metre, for display."""
