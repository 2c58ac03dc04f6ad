"""From an untrusted file to a checked `Scan`."""

from .cut import cut_garment
from .header import check_extension, check_header
from .labels import read_labels
from .limits import Limits
from .load import lies_on, load_pair, load_scan
from .load_raw import load_raw
from .pieces import ScanInput, load_scan_input
from .raw import RawScan
from .reconstruct import ReconstructedSurface, reconstruct
from .refusal import FileMissing, LabelsUnreadable
from .scan import Scan, describe_scan
from .selection import GARMENT_COLOUR_TOLERANCE, Selection, parse_colour, select_vertices
from .thin import ThinMesh, thin_mesh, thin_raw_scan, thin_scan
from .units import find_units, find_up

__all__ = [
    "GARMENT_COLOUR_TOLERANCE",
    "FileMissing",
    "LabelsUnreadable",
    "Limits",
    "RawScan",
    "ReconstructedSurface",
    "Scan",
    "ScanInput",
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
    "load_raw",
    "load_scan",
    "load_scan_input",
    "parse_colour",
    "read_labels",
    "reconstruct",
    "select_vertices",
    "thin_mesh",
    "thin_raw_scan",
    "thin_scan",
]
