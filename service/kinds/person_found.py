"""The result of segmenting a person, as the service stores it: JSON values and rows, without arrays of the scan."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ...core.run.errors import GarmentqError
from ...core.run.report import ResultReport

if TYPE_CHECKING:
    from ...core.body.body import Body


@dataclass(frozen=True)
class PersonFound:
    """Describe the result of segmenting a person.

    Attributes:
        body: The wearer.
        person: Garments, readings of the outfit, parts and body, as `describe_person` returns them.
        report: Metrics, warnings and cost.
        problem: Why nothing is recovered until a user has looked at the result, or None.
    """

    body: Body
    person: dict[str, Any]
    report: ResultReport = field(default_factory=ResultReport)
    problem: GarmentqError | None = None

    @property
    def words(self) -> tuple[str, ...]:
        """Return the garments by the words of options and folders."""
        return tuple(str(garment["part"]) for garment in self.person["garments"])

    @property
    def recovered_words(self) -> tuple[str, ...]:
        """Return those of the garments that have no problem."""
        return tuple(str(garment["part"]) for garment in self.person["garments"] if not garment.get("problem"))
