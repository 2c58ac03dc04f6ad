"""Parse what the user gives of a person's scan that would otherwise be found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body.body import Body
from ..run.errors import BadInput
from .part import GARMENTS, Part

NOTHING_WORN = "nothing"
"""Word for an outfit without a garment: bare skin, or underwear."""


class HintBad(BadInput):
    """What was said of the clothes fits no scan; correct --wearing or --mark."""

    code = "segment.hint_bad"


@dataclass(frozen=True)
class Mark:
    """Describe the part at a place in the file's own coordinates, shape [3]."""

    part: Part
    place: np.ndarray


@dataclass(frozen=True)
class Hints:
    """Describe what the user gave.

    Attributes:
        label: A `Part` for each point of the file, shape [file_count], or None to find them.
        wearing: Exactly these garments, or None to find them.
        marks: What is at single places.
        body: The wearer, in the scan's place and pose, or None to find it.
    """

    label: np.ndarray | None = None
    wearing: tuple[Part, ...] | None = None
    marks: tuple[Mark, ...] = ()
    body: Body | None = None


def parse_wearing(text: str) -> tuple[Part, ...]:
    """Parse `upper,lower`, the garments that are worn, in the order of `GARMENTS`; or `nothing`.

    Raises:
        HintBad: where a word is no garment's.
    """
    words = {part.word: part for part in GARMENTS}
    listed = [word.strip() for word in text.split(",") if word.strip()]
    if listed == [NOTHING_WORN]:
        return ()
    unknown = [word for word in listed if word not in words]
    if unknown or not listed:
        wrong = ", ".join(unknown) or text
        raise HintBad(f"'{wrong}' is no garment; name some of {', '.join(words)}, or say {NOTHING_WORN}.")
    return tuple(part for part in GARMENTS if part.word in listed)


def parse_mark(text: str) -> Mark:
    """Parse `upper=0.1,1.2,0.05`: a part, and a place in the file's own coordinates.

    Raises:
        HintBad: where it is not of that form.
    """
    word, _, numbers = text.partition("=")
    words = {part.word: part for part in Part}
    try:
        place = np.array([float(number) for number in numbers.split(",")])
    except ValueError:
        place = np.zeros(0)
    if word.strip() not in words or place.shape != (3,) or not np.isfinite(place).all():
        raise HintBad(f"'{text[:60]}' is no mark; write PART=X,Y,Z with a part of {', '.join(words)}.")
    return Mark(words[word.strip()], place)
