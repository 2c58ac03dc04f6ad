"""Formats by name, without their dependencies: a command can list them without loading any."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

FORMATS: Mapping[str, str] = MappingProxyType({
    "pdf": "garmentq.core.deliver.formats.tiled_pdf:write",
    "svg": "garmentq.core.deliver.formats.layered_svg:write",
    "dxf": "garmentq.core.deliver.formats.dxf:write",
    "marker": "garmentq.core.deliver.formats.marker:write",
    "sizes": "garmentq.core.deliver.export.sizes:write_sizes",
    "garmentcode": "garmentq.core.deliver.formats.production:write_garmentcode",
    "clo": "garmentq.core.deliver.export.program_formats:write_clo_files",
    "blender": "garmentq.core.deliver.export.program_formats:write_blender_files",
    "obj": "garmentq.core.deliver.export.program_formats:write_obj",
    "glb": "garmentq.core.deliver.export.program_formats:write_glb",
    "usd": "garmentq.core.deliver.export.program_formats:write_usd",
    "texture": "garmentq.core.deliver.export.program_formats:write_texture",
})  # fmt: skip
"""Dotted path of the writer of each format, which is loaded on first use. A writer takes a `Production` and a folder
and returns its files. A new format is one entry here."""

DIALECTS = ("aama", "astm", "clo", "gerber", "optitex", "seamly", "richpeace", "flat")
"""Dialects of DXF; `dialects.py` has their differences. `flat` is for lasers and drawing programs (`flat_dxf.py`)."""

CHARTS = ("uk-women", "de-women", "us-misses", "ru-men")
"""Names of the charts of sizes in `charts.py`."""

TABLE_UNITS: Mapping[str, float] = MappingProxyType({"cm": 1.0, "mm": 0.1, "inch": 2.54})
"""Units of lengths in tables of sizes, in centimetres."""

DESCRIPTIONS: Mapping[str, str] = MappingProxyType({
    "pdf": "sheets to print and paste at 1:1",
    "svg": "pieces with layers at 1:1",
    "dxf": "pieces for cutting programs, with dialects",
    "marker": "all copies on cloth at 1:1; closer together with the extra nest",
    "sizes": "graded sizes, their nest and rules; `garmentq sizes` chooses them",
    "garmentcode": "the pattern as GarmentCode JSON",
    "clo": "the sewn pattern for CLO and Marvelous Designer",
    "blender": "panels with sewing threads and a script for Blender's cloth",
    "obj": "all meshes with panels, seams and fabric",
    "glb": "all meshes with panels, seams and fabric",
    "usd": "all meshes with panels, seams and fabric; needs the extra usd",
    "texture": "the scan's colours on the detail mesh, and prints of the pieces",
})  # fmt: skip
"""One line on each format for users."""
