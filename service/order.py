"""What a user asks for: files, settings, and what the scan is said to be."""

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
"""What a scan may be said to be."""


@dataclass(frozen=True)
class PartOrder:
    """Describe how one garment of a person is recovered; what is None is as for all.

    Attributes:
        template: A pattern file, or None.
        name: Name of a shipped or imported template instead, or None.
        garment: Category that overrides the one found, or None.
        fabric: Name in the fabric library, a fabric itself, or None.
        lock: What the fit takes as given, separated by commas, or None.
        parts: Choices of parts of the cut, `neckline=v`, or None; they go before those for all.
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
        settings: Everything else.
        labels: A file with one label per vertex of a dressed person's scan, or None.
        given_as: One of `GIVEN_AS`, or None: found out.
        wearing: Exactly these garments of a person, `upper,lower`, or None.
        marks: What is at single places of a person, `upper=0.1,1.2,0.05` each.
        choices: Of single garments of a person, by their words.
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
    """Return whether an order is known to be of a whole person before anybody looks at its files.

    Labels, a colour or a body say that it is a garment, or a person of whom one is to be recovered. Of a body or a
    label file alone that is not the last word: the job's first stage finds out (`Recover.turn`).

    Raises:
        SettingsBad: where what was said cannot be meant together.
    """
    chosen = order.settings
    if order.given_as not in (None, *GIVEN_AS):
        raise SettingsBad(f"as '{order.given_as}' is not one of {', '.join(GIVEN_AS)}.")
    of_person = bool(order.wearing or order.marks or order.choices)
    if order.given_as == GARMENT and of_person:
        raise SettingsBad("wearing, mark and choices of a part are of a person; leave them out, or as garment.")
    if (order.given_as == PERSON or of_person) and (chosen.keep is not None or chosen.keep_colour is not None):
        raise SettingsBad("keep and keep_colour name one garment, all others of a person are found; give one of both.")
    if order.given_as == PERSON or of_person:
        return True
    is_told = chosen.keep is not None or chosen.keep_colour is not None or order.labels is not None
    return order.given_as is None and order.body is None and not is_told
