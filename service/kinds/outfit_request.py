"""The request of dressing a body in all garments of a person."""

from __future__ import annotations

from dataclasses import dataclass

from .dress_request import DressRequest
from .person_request import WORDS
from .request import RequestBad


@dataclass(frozen=True)
class OutfitRequest(DressRequest):
    """Describe a person's garments on a body, each over the one before, each in its own fabric.

    Attributes:
        order: Words of the garments from the innermost to the outermost, `lower,upper`; None only before submission,
            which derives it from the person's result.
    """

    order: str | None = None

    def __post_init__(self) -> None:
        """Refuse an invalid request.

        Raises:
            RequestBad: if one fabric is chosen for all garments, or the order has an unknown or repeated garment.
        """
        super().__post_init__()
        if self.fabric is not None:
            raise RequestBad("each garment of a person keeps its own fabric; dress in one garment's job to change it.")
        if not set(self.words) <= set(WORDS) or len(set(self.words)) < len(self.words):
            raise RequestBad(f"'order' names each garment once, innermost first, of {', '.join(WORDS)}: lower,upper.")

    @property
    def words(self) -> tuple[str, ...]:
        """Return the garments from the innermost to the outermost; empty if they are still to be found."""
        return () if self.order is None else tuple(word.strip() for word in self.order.split(","))
