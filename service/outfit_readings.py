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


MIN_NAMED_SHARE = 0.1
"""Least probability of a third of a limb, or of another category, that is named [1]."""

THIRDS = ("upper", "middle", "lower")
"""Thirds of an arm or leg, from shoulder or hip on."""


def name_end(contour: Mapping[str, Any]) -> str:
    """Return the name of a garment's end, the interval that it lies in with 0.9, and in which third of a limb it is."""
    interval, thirds = contour.get("interval_mm"), contour.get("third_probabilities")
    name = str(contour["name"]) if interval is None else f"{contour['name']} ±{interval:.0f} mm"
    if thirds is None:
        return name
    likely = sorted(((share, word) for share, word in zip(thirds, THIRDS, strict=True)), reverse=True)
    words = " or ".join(word for share, word in likely if share >= MIN_NAMED_SHARE)
    return f"{name} ({words} third)"


def name_category(garment: Mapping[str, Any]) -> str:
    """Return the category of a garment, and the other one that it may have with its probability."""
    other = garment.get("alternative")
    if other is None or other["probability"] < MIN_NAMED_SHARE:
        return str(garment["category"])
    return f"{garment['category']}, or {other['category']} ({100 * other['probability']:.0f} %)"
