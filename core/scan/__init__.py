"""From an untrusted file to a checked `Scan`."""

from .cut import cut_garment
from .header import check_extension, check_header
from .labels import read_labels
from .limits import Limits
from .load import lies_on, load_pair, load_scan
from .load_raw import load_raw
from .pieces import Pieces, load_pieces
from .raw import RawScan
from .reconstruct import Reconstructed, reconstruct
from .refusal import FileMissing, LabelsUnreadable
from .scan import Scan, describe_scan
from .selection import TOLERANCE, Selection, parse_colour, select_vertices
from .thin import ThinMesh, thin, thin_mesh, thin_scan
from .units import find_units, find_up

__all__ = [
    "TOLERANCE",
    "FileMissing",
    "LabelsUnreadable",
    "Limits",
    "Pieces",
    "RawScan",
    "Reconstructed",
    "Scan",
    "Selection",
    "ThinMesh",
    "check_extension",
    "check_header",
    "cut_garment",
    "describe_scan",
    "find_units",
    "find_up",
    "lies_on",
    "load_pair",
    "load_pieces",
    "load_raw",
    "load_scan",
    "parse_colour",
    "read_labels",
    "reconstruct",
    "select_vertices",
    "thin",
    "thin_mesh",
    "thin_scan",
]
