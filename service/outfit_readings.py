"""What a job's details say of a person in words: readings of the outfit with their probabilities, and ends."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Reading:
    """Describe one reading of what is worn.

    Attributes:
        wearing: The garments as `--wearing` takes them.
        words: The garments in words.
        share: Its probability among all readings.
    """

    wearing: str
    words: str
    share: float

    @property
    def percent(self) -> str:
        """Return its probability in per cent."""
        return f"{100 * self.share:.0f} %"


def list_readings(outfits: Sequence[Mapping[str, Any]]) -> list[Reading]:
    """Return the readings of `details["outfits"]`, in their order."""
    best = max((outfit["score"] for outfit in outfits), default=0.0)
    weights = [math.exp(outfit["score"] - best) for outfit in outfits]
    found = []
    for outfit, weight in zip(outfits, weights, strict=True):
        parts = outfit["parts"] or ["nothing"]
        found.append(Reading(",".join(parts), " and ".join(parts), weight / sum(weights)))
    return found


def name_end(contour: Mapping[str, Any]) -> str:
    """Return the name of a garment's end, with the interval that it lies in with 0.9 where that is known."""
    interval = contour.get("interval_mm")
    return str(contour["name"]) if interval is None else f"{contour['name']} ±{interval:.0f} mm"
