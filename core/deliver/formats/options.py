"""Options of an export."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...garment.pieces.allowance import read_allowances
from ...garment.pieces.make import PieceSettings
from ...run.errors import keep_printable
from ..texture.bake import check_texel
from .errors import FormatUnknown, SizesBad
from .papers import find_paper
from .registry import DIALECTS, FORMATS

MAX_SIZE_COUNT = 40
"""Largest number of sizes in one export."""

MAX_TABLE_NAME_LENGTH = 40
"""Largest length of a size's name in a table [letters]: no file hash, of 64 letters, can be a name. A DXF block's name
has 31 with the piece's."""


@dataclass(frozen=True)
class SizeLine:
    """Describe one size of a table: its name, and its girths and height [cm], None for the wearer's."""

    name: str
    bust: float | None = None
    waist: float | None = None
    hip: float | None = None
    height: float | None = None


@dataclass(frozen=True)
class ExportOptions:
    """Describe the content and format of an export.

    Attributes:
        format: One of `FORMATS`.
        dialect: One of `DIALECTS`, of DXF files.
        allowance: Seam allowances in the syntax of `read_allowances`; empty: the usual ones.
        paper: Of PDF files, as for `find_paper`.
        fold: Whether symmetric pieces are drawn as halves on the fold.
        step: Difference between sizes in bust, waist and hip [cm].
        first, last: Steps from the smallest and to the largest size; 0 is the wearer's own.
        sizes: The sizes of a table, instead of the step.
        drape: Whether each size is draped on a body by its measures.
        texel: Width of a texel of a texture [mm].
    """

    format: str
    dialect: str = DIALECTS[0]
    allowance: str = ""
    paper: str = "a4"
    fold: bool = False
    step: float = 4.0
    first: int = -2
    last: int = 2
    sizes: tuple[SizeLine, ...] = ()
    drape: bool = False
    texel: float = 1.0

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            FormatUnknown: where format, dialect or paper are unknown.
            SheetTooSmall: where a roll has another width.
            AllowanceBad: where an allowance is not valid.
            SizesBad: where sizes are not valid.
            TexelBad: where a texel has another width.
        """
        for name, known in ((self.format, tuple(FORMATS)), (self.dialect, DIALECTS)):
            if name not in known:
                raise FormatUnknown(f"'{keep_printable(str(name)[:40])}' is none of {', '.join(known)}.")
        find_paper(self.paper)
        check_texel(self.texel)
        read_allowances(self.allowance)
        if not 0.5 <= self.step <= 20.0:
            raise SizesBad(f"sizes are 0.5 to 20 cm apart, not {self.step:g}.")
        if not (self.first <= 0 <= self.last and self.last - self.first < MAX_SIZE_COUNT):
            raise SizesBad(f"steps from {self.first} to {self.last} do not hold 0, or are over {MAX_SIZE_COUNT}.")
        if len(self.sizes) > MAX_SIZE_COUNT or len({line.name for line in self.sizes}) < len(self.sizes):
            raise SizesBad(f"a table holds at most {MAX_SIZE_COUNT} sizes, each of another name.")
        if any(len(line.name) > MAX_TABLE_NAME_LENGTH for line in self.sizes):
            raise SizesBad(
                f"a size's name has at most {MAX_TABLE_NAME_LENGTH} letters; name sizes as S, M, L or 38, 40."
            )
        girths = [value for line in self.sizes for value in (line.bust, line.waist, line.hip) if value is not None]
        heights = [line.height for line in self.sizes if line.height is not None]
        if not all(math.isfinite(value) and 20.0 <= value <= 300.0 for value in (*girths, *heights)):
            raise SizesBad("girths and heights of a table are centimetres from 20 to 300.")

    @property
    def piece_settings(self) -> PieceSettings:
        """Return the settings of the pieces."""
        return PieceSettings(read_allowances(self.allowance), self.fold)
