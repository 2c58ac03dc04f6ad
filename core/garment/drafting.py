"""Write the library's pattern files: the cut of each template, drafted by the rules of a tailor's block. All are blocks
without darts or zips, for planar placement. A draft is made in the front plane seen from outside: x to the wearer's
left, y up. Seams are equal because both sides are the same curve, or because one corner was solved for."""

from __future__ import annotations

from pathlib import Path

from .garmentcode import save_pattern
from .parts.draft import draft_cut
from .parts.shipped_cuts import CUTS


def write_library(folder: Path) -> None:
    """Draft every template and write its pattern file: `python -m garmentq.core.garment.drafting`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, cut in CUTS.items():
        save_pattern(draft_cut(cut, name=name), folder / f"{name}.json")


if __name__ == "__main__":
    write_library(Path(__file__).parent / "library")
