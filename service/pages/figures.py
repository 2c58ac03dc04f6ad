"""The picture of one figure: cut from the pictures that a result has, one view from the front."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import lru_cache

from PIL import Image, ImageChops, ImageOps, PngImagePlugin, WebPImagePlugin

from ..records import Artifact
from ..services import Services
from ..store import Store
from .stored_files import MAX_REPORT_FILE_SIZE, REPORT, find_file, read_picture

PICTURE_FILE = "picture.png"
"""File of a person's or an outfit's picture, which its report repeats."""

FIGURE_SIZE_PX = (280, 400)
"""Largest width and height of a figure [pixels]: twice the size in a card, for dense screens."""

FIGURE_MARGIN_PX = 8
"""White space about a figure [pixels]."""

MIN_INK = 6
"""Smallest difference from white of a pixel that belongs to the figure [levels of 255]."""

FIGURE_FORMAT = WebPImagePlugin.WebPImageFile.format
"""Format of figures. Its plugin and that of their sources are imported with the server: with the first picture Pillow
would import those of all formats, 0.2 s of CPU."""

SHEET_FORMATS = (PngImagePlugin.PngImageFile.format,)
"""Formats of the sheets."""

FIGURE_QUALITY = 82
"""Number for the quality of WebP from 0 to 100; above it files grow and nothing more is seen."""


@dataclass(frozen=True)
class Sheet:
    """Describe where the figure stands on a sheet of pictures.

    Attributes:
        title: Beginning of the sheet's title in the report.
        columns: Number of pictures in a row.
        ratio: Height of a picture as a multiple of its width; 0: the sheet is one picture.
        row: Row of the figure, from 0; it is the first in it.
    """

    title: str
    columns: int = 1
    ratio: float = 0.0
    row: int = 0


SHEETS = (
    Sheet("Detail mesh, front"),
    Sheet("both wearers", 3, 1.6, 1),
    Sheet("all garments", 3, 1.6),
    Sheet("the garment before and after", 3, 1.6, 1),
    Sheet("contact sheet", 6, 1.5),
    Sheet("scan, body", 4, 1.6),
)
"""Sheets of the reports of each kind of job, by which `find_figure` chooses: a garment on its wearer, a dressed wearer,
a scan of a person as it was dressed."""

FILE_SHEETS = {"person": SHEETS[5], "outfit": SHEETS[2]}
"""Sheet of the file `PICTURE_FILE` by the kind of job."""


@dataclass(frozen=True)
class FigureSource:
    """Describe the stored file from which a figure is cut; `sheet` is None if it is a report."""

    sha256: str
    sheet: Sheet | None


def find_figure(services: Services, job: str, kind: str) -> FigureSource | None:
    """Return the file that has a job's figure, or None if it has none."""
    sheet = FILE_SHEETS.get(kind)
    file: Artifact | None = find_file(services, job, PICTURE_FILE) if sheet else None
    if file is None:
        file, sheet = find_file(services, job, REPORT), None
    return FigureSource(file.sha256, sheet) if file and file.size <= MAX_REPORT_FILE_SIZE else None


@lru_cache(maxsize=4096)
def cut_figure(store: Store, source: FigureSource) -> bytes | None:
    """Return a figure on white as WebP, or None if the file has no picture of it."""
    if source.sheet is not None:
        return _cut(store.get_bytes(source.sha256), source.sheet)
    report = store.get_bytes(source.sha256)
    pictures = ((sheet, read_picture(report, sheet.title)) for sheet in SHEETS)
    return next((_cut(picture, sheet) for sheet, picture in pictures if picture is not None), None)


def _cut(content: bytes, sheet: Sheet) -> bytes | None:
    """Return the figure of a sheet without the white about it."""
    try:
        with Image.open(io.BytesIO(content), formats=SHEET_FORMATS) as whole:
            width = whole.width // sheet.columns
            height = round(width * sheet.ratio) or whole.height
            part = whole.crop((0, sheet.row * height, width, (sheet.row + 1) * height)).convert("RGBA")
    except (OSError, Image.DecompressionBombError):
        return None
    figure = Image.new("RGB", part.size, "white")
    figure.paste(part, mask=part)
    ink = ImageChops.difference(figure, Image.new("RGB", part.size, "white")).convert("L")
    box = ink.point([0] * MIN_INK + [255] * (256 - MIN_INK)).getbbox()
    if box is None:
        return None
    figure = ImageOps.expand(figure.crop(box), FIGURE_MARGIN_PX, "white")
    figure.thumbnail(FIGURE_SIZE_PX)
    out = io.BytesIO()
    figure.save(out, FIGURE_FORMAT, quality=FIGURE_QUALITY, method=2)
    return out.getvalue()
