"""Check a user's fabric: name, source and range of each number."""

from __future__ import annotations

import math
import re
from functools import cache

from ..run.errors import BadInput
from .fabric import Fabric
from .fabrics import PARAMETERS, load_fabrics
from .settings import STANDARD_GRAVITY

NAME = re.compile(r"[a-z0-9][a-z0-9_.-]{0,63}", re.ASCII)
ORIGINS = ("measured", "derived", "assumed")
"""First word of a source."""

MIN_SOURCE_LENGTH, MAX_SOURCE_LENGTH = 10, 1000
"""Smallest and largest length of a source after its origin [characters]. A shorter one cannot name a place."""

MAX_FABRIC_TITLE_LENGTH = 255
"""Largest length of a fabric's title [characters]."""
FABRIC_RANGE_FACTOR = 10.0
"""Factor by which a fabric's numbers may exceed the library's range. It allows felt and gauze; a wrong unit (g for kg,
mm for m, uN for N) is a factor of 1000 or more and is refused."""

FRICTION_COEFFICIENT_RANGE = (0.0, 2.0)
"""Range of Coulomb coefficients [1]. Cloth on skin is between 0.2 and 1, on wet skin up to twice that."""

MAX_SELF_WEIGHT_STRAIN = 0.2
"""Largest strain [1] of cloth under the weight of a metre of itself. Beyond it the linear membrane is not valid."""


class FabricNameBad(BadInput):
    """A fabric's name has 1 to 64 small letters, digits, '_', '.' and '-', its title at most 255 printable letters."""

    code = "fabric.name_bad"


class FabricSourceBad(BadInput):
    """Each number of a fabric needs a source: `measured: where`, `derived: how` or `assumed: plausible range`."""

    code = "fabric.source_bad"


class FabricOutOfRange(BadInput):
    """A number of the fabric is outside its range; check its unit."""

    code = "fabric.out_of_range"


@cache
def find_ranges() -> dict[str, tuple[float, float]]:
    """Return the lowest and the highest value of each parameter in SI units, by `FABRIC_RANGE_FACTOR` and
    `FRICTION_COEFFICIENT_RANGE`."""
    found = {name: [getattr(fabric, name) for fabric in load_fabrics()] for name in PARAMETERS}
    return {name: (min(row) / FABRIC_RANGE_FACTOR, max(row) * FABRIC_RANGE_FACTOR) for name, row in found.items()} | {
        "friction": FRICTION_COEFFICIENT_RANGE
    }


def check_fabric(fabric: Fabric) -> Fabric:
    """Check a user's fabric, and return it.

    Raises:
        FabricNameBad: where name or title cannot be used.
        FabricSourceBad: where a number has no source.
        FabricOutOfRange: where a number is outside its range, or the membrane is not positive definite.
    """
    title = fabric.title
    if not NAME.fullmatch(fabric.name) or len(title) > MAX_FABRIC_TITLE_LENGTH or not title.isprintable():
        raise FabricNameBad()
    if title and not title[0].isalnum():  # a spreadsheet takes '=1+1' for a formula
        raise FabricNameBad(f"the title of '{fabric.name}' does not begin with a letter or a digit.")
    _check_sources(fabric)
    _check_numbers(fabric)
    return fabric


def _check_sources(fabric: Fabric) -> None:
    sources = dict(fabric.sources)
    for name in PARAMETERS:
        origin, _, text = sources.get(name, "").partition(":")
        is_text = MIN_SOURCE_LENGTH <= len(text.strip()) and len(text) <= MAX_SOURCE_LENGTH and text.isprintable()
        if origin not in ORIGINS or not is_text:
            raise FabricSourceBad(f"{name} of '{fabric.name}' has no source. {FabricSourceBad().message}")
    if len(fabric.sources) != len(PARAMETERS) or set(sources) != set(PARAMETERS):
        raise FabricSourceBad(f"'{fabric.name}' has sources of numbers that a fabric does not have; leave them out.")


def _check_numbers(fabric: Fabric) -> None:
    for name, (low, high) in find_ranges().items():
        value = getattr(fabric, name)
        if not (math.isfinite(value) and low <= value <= high):
            raise FabricOutOfRange(
                f"{name} of '{fabric.name}' is {value:.6g}, outside {low:.3g} to {high:.3g} (SI units); check its unit."
            )
    if fabric.H01**2 >= fabric.H00 * fabric.H11:
        raise FabricOutOfRange(f"'{fabric.name}' gains energy by stretching: H01^2 must be below H00 H11.")
    stretch = fabric.density * -STANDARD_GRAVITY[1] / min(fabric.H00, fabric.H11)
    if stretch > MAX_SELF_WEIGHT_STRAIN:
        raise FabricOutOfRange(
            f"a metre of '{fabric.name}' stretches by {stretch:.0%} under its own weight, "
            f"more than {MAX_SELF_WEIGHT_STRAIN:.0%}; check density, H00 and H11."
        )
