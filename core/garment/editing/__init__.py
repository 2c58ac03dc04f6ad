"""Operations of a pattern maker, each a pure function of a `Pattern`: move, reshape, divide, cut, join."""

from .cutting import cut_panel
from .darts import Dart, close_dart, find_darts, insert_dart
from .dividing import merge_edges, split_edges
from .errors import EditBad
from .joining import join_panels
from .moving import move_points
from .operations import apply_operations, edit_file
from .reshaping import sharpen_corner, smooth_corner, straighten_edges

__all__ = [
    "Dart",
    "EditBad",
    "apply_operations",
    "close_dart",
    "cut_panel",
    "edit_file",
    "find_darts",
    "insert_dart",
    "join_panels",
    "merge_edges",
    "move_points",
    "sharpen_corner",
    "smooth_corner",
    "split_edges",
    "straighten_edges",
]
