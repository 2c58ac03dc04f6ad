"""From an untrusted file to a checked `Scan`."""

from .limits import Limits
from .load import lies_on, load_pair, load_scan, vertex_normals
from .scan import Scan
from .units import find_units, find_up

__all__ = ["Limits", "Scan", "find_units", "find_up", "lies_on", "load_pair", "load_scan", "vertex_normals"]
