"""Errors of exports, with one stable code each."""

from __future__ import annotations

from ...run.errors import BadInput


class FormatUnknown(BadInput):
    """No such format, dialect or paper; `garmentq export --help` lists them."""

    code = "export.unknown"


class SheetTooSmall(BadInput):
    """The paper is too narrow for tiles with their margins; take a larger one."""

    code = "export.paper"


class SizesBad(BadInput):
    """Sizes are a step in centimetres with a range that includes 0, or a table of names, bust, waist and hip."""

    code = "export.sizes"


class SizesUnclear(BadInput):
    """A table of sizes can hardly be meant as it is; say its unit, correct it, or confirm it with --sure."""

    code = "export.sizes_unclear"
