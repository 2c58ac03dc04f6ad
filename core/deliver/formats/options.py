"""Options of an export."""

from __future__ import annotations

from dataclasses import dataclass

from ...garment.pieces.allowance import read_allowances
from ...garment.pieces.make import PieceSettings
from ...run.errors import keep_printable
from ..texture.bake import check_texel
from .charts import find_chart
from .errors import FormatUnknown, SizesBad
from .papers import find_paper
from .registry import CHARTS, DIALECTS, FORMATS, TABLE_UNITS
from .size_lines import MAX_SIZE_COUNT, SizeLine, check_size_lines


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
        chart: Name of one of `CHARTS`, instead of both; None for none.
        chosen: Names of the sizes of a table or chart that are wanted; None: all.
        unit: Of the grade table: one of `TABLE_UNITS`; None: cm.
        is_sure: Whether a table that looks wrong is meant as it is; None: no.
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
    chart: str | None = None
    chosen: tuple[str, ...] | None = None
    unit: str | None = None
    is_sure: bool | None = None
    drape: bool = False
    texel: float = 1.0

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            FormatUnknown: where format, dialect or paper are unknown.
            SheetTooSmall: where a roll has another width.
            AllowanceBad: where an allowance is not valid.
            SizesBad: where sizes are not valid.
            SizesUnclear: where a table can hardly be meant as it is.
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
        if self.unit is not None and self.unit not in TABLE_UNITS:
            raise SizesBad(f"'{keep_printable(self.unit[:40])}' is none of the units {', '.join(TABLE_UNITS)}.")
        check_size_lines(self.sizes, bool(self.is_sure))
        if self.chart and self.sizes:
            raise SizesBad("a table and a chart are two tables of sizes; give one of them.")
        if self.chart and self.chart not in CHARTS:
            raise SizesBad(f"'{keep_printable(self.chart[:40])}' is none of the charts {', '.join(CHARTS)}.")
        unknown = set(self.chosen or ()) - {line.name for line in self.sizes or find_chart(self.chart)}
        if unknown:
            raise SizesBad(f"'{keep_printable(min(unknown)[:40])}' is the name of no size of the table or chart.")

    @property
    def size_lines(self) -> tuple[SizeLine, ...]:
        """Return the sizes of the table or the chart; none for steps."""
        return self.sizes or find_chart(self.chart)

    @property
    def piece_settings(self) -> PieceSettings:
        """Return the settings of the pieces."""
        return PieceSettings(read_allowances(self.allowance), self.fold)
