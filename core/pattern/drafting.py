"""Every base pattern, drafted from body measures by the rules of a tailor's block.

All are blocks without darts or zips, for planar placement: front and back stand before and behind the body, and
half sleeves continue them in the same plane, so that a flattened body in T-pose fits between. A draft is made in the
front plane seen from outside: x to the wearer's left, y up. Seams are equal because both sides are the same curve, or
because one corner was solved for (trousers, shorts, jumpsuit).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .draft_legs import draft_jumpsuit, draft_shorts, draft_sleeved_jumpsuit, draft_trousers
from .draft_skirts import draft_four_panel_skirt, draft_pencil_skirt, draft_skirt
from .draft_tops import draft_dress, draft_long_sleeve_tshirt, draft_sleeved_dress, draft_tank, draft_tshirt
from .garmentcode import save_pattern
from .measures import BodyMeasures
from .pattern import Pattern

__all__ = ["DRAFTS", "BodyMeasures", "write_library"]

DRAFTS: dict[str, Callable[..., Pattern]] = {
    "tshirt": draft_tshirt,
    "long_sleeve_tshirt": draft_long_sleeve_tshirt,
    "tank": draft_tank,
    "dress": draft_dress,
    "sleeved_dress": draft_sleeved_dress,
    "trousers": draft_trousers,
    "shorts": draft_shorts,
    "skirt": draft_skirt,
    "four_panel_skirt": draft_four_panel_skirt,
    "pencil_skirt": draft_pencil_skirt,
    "jumpsuit": draft_jumpsuit,
    "sleeved_jumpsuit": draft_sleeved_jumpsuit,
}
"""The draft of each template by name; each takes `BodyMeasures`."""


def write_library(folder: Path) -> None:
    """Draft every template and write its pattern file: `python -m garmentq.core.pattern.drafting`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, draft in DRAFTS.items():
        save_pattern(draft(), folder / f"{name}.json")


if __name__ == "__main__":
    write_library(Path(__file__).parent / "library")
