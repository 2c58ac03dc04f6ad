"""A user's order: files, settings, and options about the scan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..core.body.spec import Wearer
from ..core.cloth.fabric import Fabric
from ..core.recover.settings import RecoverySettings, SettingsBad
from .terms import JobTerms

PERSON, GARMENT = "person", "garment"
GIVEN_AS = (PERSON, GARMENT)
"""Values of the option that says what a scan is."""


@dataclass(frozen=True)
class PartOrder:
    """Describe how one garment of a person is recovered; None stands for the choice for all garments.

    Attributes:
        template: A pattern file, or None.
        name: Name of a shipped or imported template instead, or None.
        garment: Category that overrides the detected one, or None.
        fabric: Name in the fabric library, a fabric itself, or None.
        lock: Parameters that the fit must not change, separated by commas, or None.
        parts: Choices of parts of the cut, `neckline=v`, or None; they override those for all garments.
    """

    template: Path | None = None
    name: str | None = None
    garment: str | None = None
    fabric: str | Fabric | None = None
    lock: str | None = None
    parts: str | None = None


@dataclass(frozen=True)
class Order:
    """Describe what is to be recovered.

    Attributes:
        scan: The garment's file, or the whole person's.
        body: The wearer's file, a built-in body, or None.
        template: A pattern file, or None.
        settings: All other settings.
        labels: A file with one label per vertex of a dressed person's scan, or None.
        given_as: One of `GIVEN_AS`, or None: detected.
        wearing: Exactly these garments of a person, `upper,lower`, or None.
        marks: Parts of single points of a person, `upper=0.1,1.2,0.05` each.
        choices: Choices for single garments of a person, by their words.
        terms: How the job is queued.
    """

    scan: Path
    body: Wearer | None
    template: Path | None = None
    settings: RecoverySettings = field(default_factory=RecoverySettings)
    labels: Path | None = None
    given_as: str | None = None
    wearing: str | None = None
    marks: tuple[str, ...] = ()
    choices: Mapping[str, PartOrder] = field(default_factory=dict)
    terms: JobTerms = field(default_factory=JobTerms)


def is_person(order: Order) -> bool:
    """Return whether an order is known to be of a whole person before its files are read.

    Labels, a colour or a body indicate a garment, or a person of whom one garment is to be recovered. With a body or a
    label file alone this is preliminary: the job's first stage decides (`Recover.turn`).

    Raises:
        SettingsBad: if options contradict each other.
    """
    chosen = order.settings
    if order.given_as not in (None, *GIVEN_AS):
        raise SettingsBad(f"as '{order.given_as}' is not one of {', '.join(GIVEN_AS)}.")
    of_person = bool(order.wearing or order.marks or order.choices)
    if order.given_as == GARMENT and of_person:
        raise SettingsBad("wearing, mark and choices of a part are for a person; leave them out, or as garment.")
    if (order.given_as == PERSON or of_person) and (chosen.keep is not None or chosen.keep_colour is not None):
        raise SettingsBad("keep and keep_colour choose one garment, person recovers all; use one of both.")
    if order.given_as == PERSON or of_person:
        return True
    is_garment = chosen.keep is not None or chosen.keep_colour is not None or order.labels is not None
    return order.given_as is None and order.body is None and not is_garment
