"""Interpret the columns of a file's vertices: labels by the usual names, colours as bytes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

LABELS = ("label", "labels", "is_garment", "segment", "segment_id", "class")
"""Names that scanners and labelling tools give to an integer per vertex, in any case."""
SCALAR_FIELD_PREFIX = "scalar_"
"""Prefix that CloudCompare adds to the name of a scalar field, which it writes as floats."""

COLOUR_NAMES = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
"""Names of the columns of a vertex's colour."""
SPLAT_COLOUR_NAMES, SPLAT_OPACITY_NAME = ("f_dc_0", "f_dc_1", "f_dc_2"), "opacity"
"""Names of a Gaussian splat's columns: the colour's mean over all directions, and the logit of the opacity."""
SPLAT_COLOUR_FACTOR = 0.5 / np.sqrt(np.pi)
"""The spherical harmonic of degree 0 [1], by which a splat's mean colour less a half is divided (Kerbl et al. 2023)."""


def read_fields(rows: Any) -> dict[str, np.ndarray]:
    """Return the columns of a structured array or a dictionary of arrays, by their names in lower case."""
    names = getattr(getattr(rows, "dtype", None), "names", None) or (rows.keys() if isinstance(rows, dict) else ())
    return {str(name).lower().removeprefix(SCALAR_FIELD_PREFIX): rows[name] for name in names}


def find_colours(fields: Mapping[str, np.ndarray], count: int) -> np.ndarray | None:
    """Return the RGB bytes of `count` vertices, shape [count, 3], from columns with the usual names, or None."""
    for names in (*COLOUR_NAMES, SPLAT_COLOUR_NAMES):
        columns = [np.ravel(fields[name]) for name in names if name in fields]
        if len(columns) == 3 and all(len(column) == count for column in columns):
            found = np.stack(columns, axis=1)
            return as_bytes(np.clip(0.5 + SPLAT_COLOUR_FACTOR * found, 0.0, 1.0) if names[0] == "f_dc_0" else found)
    return None


def find_opacity(fields: Mapping[str, np.ndarray], count: int) -> np.ndarray | None:
    """Return the opacities of `count` Gaussian splats, 0 to 1, shape [count], or None of points that are none."""
    if not {*SPLAT_COLOUR_NAMES, SPLAT_OPACITY_NAME} <= set(fields):
        return None
    logit = np.ravel(fields[SPLAT_OPACITY_NAME]).astype(np.float64)
    return 1.0 / (1.0 + np.exp(-np.clip(logit, -50.0, 50.0))) if len(logit) == count else None


def find_labels(fields: Mapping[str, np.ndarray], count: int) -> np.ndarray | None:
    """Return the first column with one of the usual names that has `count` whole numbers, int64, or None."""
    for name in LABELS:
        values = np.ravel(fields[name]) if name in fields else np.zeros(0)
        if len(values) == count and count and are_whole(values):
            return values.astype(np.int64)
    return None


def are_whole(values: np.ndarray) -> bool:
    """Check whether numbers are integers, also if they are stored as floats."""
    if values.dtype.kind == "f":
        return bool((np.abs(values) < 2**31).all() and (values == np.round(values)).all())
    return values.dtype.kind in "iu"


def as_bytes(colours: np.ndarray) -> np.ndarray:
    """Return colours as bytes; floats in 0..1 are scaled."""
    if np.issubdtype(colours.dtype, np.floating):
        finite = np.nan_to_num(colours)
        scale = 255.0 if finite.size and finite.max() <= 1.0 else 1.0
        found: np.ndarray = np.clip(np.round(finite * scale), 0, 255).astype(np.uint8)
        return found
    found = np.clip(colours, 0, 255).astype(np.uint8)
    return found
