"""Formats by name, without what they need: a command may list them and load nothing."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

FORMATS: Mapping[str, str] = MappingProxyType({
    "pdf": "garmentq.core.formats.tiled_pdf:write",
    "svg": "garmentq.core.formats.layered_svg:write",
    "dxf": "garmentq.core.formats.dxf:write",
    "sizes": "garmentq.core.formats.nest:write",
    "garmentcode": "garmentq.core.formats.production:write_garmentcode",
})  # fmt: skip
"""Dotted path of the writer of each format by name; a writer takes a `Production` and a folder and returns its files.
A new format is one entry here; its module is loaded when it is asked for."""

DIALECTS = ("aama", "astm", "clo", "gerber", "optitex", "seamly", "richpeace")
"""Whose reading of DXF a file is written for; `dialects.py` says how they differ."""

DESCRIPTIONS: Mapping[str, str] = MappingProxyType({
    "pdf": "sheets to print and paste at 1:1",
    "svg": "pieces with layers at 1:1",
    "dxf": "pieces for cutting programs, with dialects",
    "sizes": "graded sizes, their nest and rules; `garmentq sizes` chooses them",
    "garmentcode": "the pattern as GarmentCode JSON",
})  # fmt: skip
"""One line of each format for people."""
