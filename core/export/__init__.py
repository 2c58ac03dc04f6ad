"""Writers of patterns, meshes, the result folder and its report."""

from .layout import lay_out
from .meshes import uv_layout, write_meshes, write_ply
from .report import report_html
from .result import plain, write_recovery

__all__ = ["lay_out", "plain", "report_html", "uv_layout", "write_meshes", "write_ply", "write_recovery"]
