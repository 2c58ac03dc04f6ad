"""Find a file's unit and up axis from the possible sizes of a garment or a body."""

from __future__ import annotations

import numpy as np

from ..geometry.connectivity import HalfEdges
from ..geometry.geometry import face_normals
from ..run.units import METRIC, UNITS
from .refusal import ChoiceBad, UnitsAmbiguous, UnitsUnknown, UpAmbiguous

AXES = ("y", "z")
BODY_LONGEST = (0.95, 2.4)
"""Range of the longest side of a body's bounding box [m]: height or arm span from a small child on. The ratio of both
is below 2.54, so that no body in inches passes as one in centimetres."""
FORM_LONGEST = (0.5, 0.95)
"""Range of the longest side of a dress form's bounding box [m], for meshes that are no whole body in any unit: from
hips to neck, or from the thighs."""
LONGEST_SIDES = {"body": BODY_LONGEST, "form": FORM_LONGEST}
"""Range of the longest side of what is measured by that alone [m]."""
GARMENT_LONGEST = (0.28, 2.3)
"""Range of the longest side of a worn garment's bounding box [m]: from shorts to the span of long sleeves or a gown."""
GARMENT_SHORTEST = (0.16, 1.2)
"""Range of the shortest side of a worn garment's bounding box [m]: it goes around a trunk, which is at least that deep.
A garment of an adult in inches (17 to 45 cm deep) would be 7 to 18 cm deep in centimetres."""
GARMENT_AREA = (0.2, 8.0)
"""Range of a garment's area [m2]: from shorts to a ball gown."""
GIVEN_LONGEST = (0.1, 5.0)
"""Range of the longest side that is accepted where the user names the unit [m]."""
UP_RATIO = 1.3
"""Least ratio by which one axis must exceed the other; a seated body seen from above is at most as wide as deep."""


def check_choice(units: str | None, up: str | None) -> None:
    """Check the unit and the axis that the user gave.

    Raises:
        ChoiceBad: where one is none of the allowed words.
    """
    if units is not None and units not in UNITS:
        raise ChoiceBad(f"units '{units}' are not known; give {', '.join(UNITS)}.")
    if up is not None and up not in AXES:
        raise ChoiceBad(f"up axis '{up}' is not known; give y or z.")


def _fits(extent: np.ndarray, area: float | None, scale: float, kind: str) -> bool:
    longest, shortest = float(extent.max()) * scale, float(extent.min()) * scale
    if kind in LONGEST_SIDES:
        least, most = LONGEST_SIDES[kind]
        return least <= longest <= most
    fits = GARMENT_LONGEST[0] <= longest <= GARMENT_LONGEST[1] and (
        GARMENT_SHORTEST[0] <= shortest <= GARMENT_SHORTEST[1]
    )
    return fits and (area is None or GARMENT_AREA[0] <= area * scale**2 <= GARMENT_AREA[1])


def _measure(vertices: np.ndarray, faces: np.ndarray | None) -> tuple[np.ndarray, float | None]:
    return np.ptp(vertices, axis=0), None if faces is None else float(face_normals(vertices, faces)[1].sum())


def possible_units(vertices: np.ndarray, faces: np.ndarray | None = None, kind: str = "garment") -> list[str]:
    """List the units of `METRIC` in which a mesh has the size of a `garment`, a `body`, or else of a dress `form`.

    A form of 70 cm may be a person of 70 inches: where another unit makes a body of it, it is not taken for a form.
    """
    extent, area = _measure(vertices, faces)
    found = [name for name in METRIC if _fits(extent, area, UNITS[name], kind)]
    if found or kind != "body" or any(_fits(extent, area, scale, kind) for scale in UNITS.values()):
        return found
    return possible_units(vertices, faces, "form")


def find_units(vertices: np.ndarray, kind: str = "garment", *, faces: np.ndarray | None = None) -> str:
    """Find the unit (`m`, `cm` or `mm`) in which positions [unit], shape [n, 3], measure a `garment` or a `body`.

    Raises:
        UnitsUnknown: where none fits (a toy, a room), also for inches and feet, which have to be given.
        UnitsAmbiguous: where several fit.
    """
    extent, area = _measure(vertices, faces)
    found = possible_units(vertices, faces, kind)
    size = " x ".join(f"{value:.3g}" for value in extent)
    if len(found) > 1:
        raise UnitsAmbiguous(f"The {kind} measures {size}, which fits {' and '.join(found)}; say which with --units.")
    if not found:
        others = [name for name in UNITS if name not in METRIC and _fits(extent, area, UNITS[name], kind)]
        advice = f"but {others[0]}; say --units {others[0]}" if others else "convert it, or say its unit with --units"
        raise UnitsUnknown(f"The {kind} measures {size}, which fits neither m, cm nor mm, {advice}.")
    return found[0]


def check_size(vertices: np.ndarray, units: str, kind: str) -> None:
    """Check that the unit given by the user is possible.

    Raises:
        UnitsUnknown: where the mesh would be smaller than 10 cm or larger than 5 m.
    """
    longest = float(np.ptp(vertices, axis=0).max()) * UNITS[units]
    if not GIVEN_LONGEST[0] <= longest <= GIVEN_LONGEST[1]:
        raise UnitsUnknown(f"In {units} the {kind} would be {longest:.3g} m long; give its true unit with --units.")


def find_up(vertices: np.ndarray, edges: HalfEdges, kind: str = "garment") -> str:
    """Find the axis (`y` or `z`) that points up.

    A body is longer than deep. A garment's openings (hem, waist, neck) face up and down, so that the absolute
    components of their area vectors add up to most along the up axis; sleeves in a T-pose add to x only.

    Raises:
        UpAmbiguous: where neither axis exceeds the other by `UP_RATIO`.
    """
    from .repair import boundary_pieces

    if kind == "body":
        _, y, z = np.ptp(vertices, axis=0)
    else:
        areas = boundary_pieces(vertices, edges)[3]
        _, y, z = np.abs(areas).sum(axis=0) if len(areas) else np.ptp(vertices, axis=0)
    if y >= UP_RATIO * z:
        return "y"
    if z >= UP_RATIO * y:
        return "z"
    raise UpAmbiguous(f"Whether y or z points up in the {kind}'s file is not clear; say which with --up y or z.")


def to_metres(vertices: np.ndarray, units: str, up: str) -> np.ndarray:
    """Return positions in metres with y up; with z up (x, y, z) becomes (x, z, -y)."""
    scaled = vertices * UNITS[units]
    return scaled if up == "y" else np.stack([scaled[:, 0], scaled[:, 2], -scaled[:, 1]], axis=1)
