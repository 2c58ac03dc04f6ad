"""Writers of production formats: what is cut, printed or read by other cutting programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...run.lazy import import_lazily
from .errors import FormatUnknown, SheetTooSmall, SizesBad
from .options import ExportOptions, SizeLine
from .papers import PAPERS, find_paper
from .registry import DESCRIPTIONS, DIALECTS, FORMATS

if TYPE_CHECKING:
    from .production import Production, describe_size, write_production

_LAZY = {"Production": "production", "describe_size": "production", "write_production": "production"}
# What needs bodies and drapes is imported on first use: a service checks options without it.

__getattr__ = import_lazily(__name__, _LAZY)

__all__ = [
    "DESCRIPTIONS",
    "DIALECTS",
    "FORMATS",
    "PAPERS",
    "ExportOptions",
    "FormatUnknown",
    "Production",
    "SheetTooSmall",
    "SizeLine",
    "SizesBad",
    "describe_size",
    "find_paper",
    "write_production",
]
