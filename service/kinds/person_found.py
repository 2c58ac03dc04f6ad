"""What taking a person apart found, as the service keeps it: JSON values and rows, no arrays of the scan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ...core.run.errors import GarmentqError

if TYPE_CHECKING:
    from ...core.body import Body


@dataclass(frozen=True)
class PersonFound:
    """What was found of a person.

    Attributes:
        body: The wearer.
        person: Garments, readings of the outfit, parts and body, as `describe_person` says it.
        metrics: Flat dotted names to numbers.
        warnings: What the user should know, one sentence each.
        problem: Why nothing is recovered from this without a person's look, or None.
        stage_seconds: CPU seconds by stage name.
        cpu_seconds: CPU seconds of the whole [s].
        peak_mb: Largest resident memory of the process [MB].
    """

    body: Body
    person: dict[str, Any]
    metrics: Mapping[str, float | None] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    problem: GarmentqError | None = None
    stage_seconds: Mapping[str, float] = field(default_factory=dict)
    cpu_seconds: float = 0.0
    peak_mb: float = 0.0

    @property
    def words(self) -> tuple[str, ...]:
        """Return the garments by the words of options and folders."""
        return tuple(str(garment["part"]) for garment in self.person["garments"])
