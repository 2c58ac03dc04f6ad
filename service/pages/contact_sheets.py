"""Contact sheets of reports: what their columns show, and one column of a sheet as a picture of its own."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import lru_cache


@dataclass(frozen=True)
class ContactSheet:
    """Describe the columns of a kind of sheet.

    Attributes:
        title: Beginning of the sheet's title in the report.
        heads: What each column shows.
        bare: Columns that show bare skin; a page shows them on demand only.
    """

    title: str
    heads: tuple[str, ...]
    bare: tuple[int, ...] = ()


PERSON_SHEET = ContactSheet("scan, body", ("Scan", "Body", "Parts", "Confidence"), bare=(1,))

CONTACT_SHEETS = (
    PERSON_SHEET,
    ContactSheet("both wearers", ("Front", "Side", "Back")),
    ContactSheet("all garments", ("Front", "Side", "Back")),
    ContactSheet("the garment before and after", ("Front", "Side", "Back")),
)
"""The kinds of sheets whose columns have heads."""


def find_contact_sheet(title: str) -> ContactSheet | None:
    """Return the kind of a sheet by its title in the report, or None for another picture."""
    return next((sheet for sheet in CONTACT_SHEETS if title.startswith(sheet.title)), None)


@lru_cache(maxsize=32)
def cut_column(content: bytes, column: int, count: int) -> bytes:
    """Return one of the equal columns of a picture as PNG.

    Args:
        content: The picture.
        column: The column, from 0.
        count: Number of columns.
    """
    from PIL import Image

    with Image.open(io.BytesIO(content)) as whole:
        width = whole.width // count
        out = io.BytesIO()
        whole.crop((column * width, 0, (column + 1) * width, whole.height)).save(out, "PNG")
    return out.getvalue()
