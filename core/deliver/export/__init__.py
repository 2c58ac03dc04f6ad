"""Writers of patterns, meshes, the result folder and its report."""

from ...garment import save_pattern, write_pattern
from .animation import write_animation
from .meshes import uv_layout, write_meshes, write_ply
from .pattern_svg import pattern_svg, write_svg
from .report import report_html
from .result import to_plain_json, write_recovery

__all__ = [
    "pattern_svg",
    "report_html",
    "save_pattern",
    "to_plain_json",
    "uv_layout",
    "write_animation",
    "write_meshes",
    "write_pattern",
    "write_ply",
    "write_recovery",
    "write_svg",
]
