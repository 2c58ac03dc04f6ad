"""Define the errors for files that are refused, each with a stable code and the user's next step."""

from __future__ import annotations

from ..run.errors import BadInput


class FileMissing(BadInput):
    """There is no such file; check the path."""

    code = "scan.missing"


class FormatUnknown(BadInput):
    """This kind of file is not read; export the mesh as PLY, OBJ, STL, OFF or GLB, or a cloud as PLY, PCD or XYZ."""

    code = "scan.format"


class ArchiveRefused(BadInput):
    """The file is an archive; unpack it and give the mesh file inside."""

    code = "scan.archive"


class ContentMismatch(BadInput):
    """The content is not what the file's extension says; export the mesh again or rename the file."""

    code = "scan.magic"


class FileTooLarge(BadInput):
    """The file is larger than what is read; decimate the mesh first."""

    code = "scan.too_large"


class CountTooLarge(BadInput):
    """The file claims more elements than are read; decimate the mesh, or check that the file is not damaged."""

    code = "scan.too_many"


class FileTruncated(BadInput):
    """The file is shorter than its header says; export or copy it again."""

    code = "scan.truncated"


class HeaderBroken(BadInput):
    """The header cannot be understood; export the mesh again."""

    code = "scan.header"


class OutsideReference(BadInput):
    """The glTF points to files outside itself; export it as one GLB with everything embedded."""

    code = "scan.outside_uri"


class ExtensionUnsupported(BadInput):
    """The glTF needs an extension that is not read; export it as GLB without compression."""

    code = "scan.gltf_extension"


class Unreadable(BadInput):
    """The file could not be parsed; export the mesh again."""

    code = "scan.unreadable"


class NoFaces(BadInput):
    """The file holds no triangles, and only a whole person may be points alone; give the garment or body as a mesh."""

    code = "scan.no_faces"


class MeshEmpty(BadInput):
    """The file holds no vertices; export the mesh again."""

    code = "scan.empty"


class IndicesBroken(BadInput):
    """A face refers to a vertex that does not exist; export the mesh again."""

    code = "scan.indices"


class NotFinite(BadInput):
    """A coordinate is NaN or infinite; clean the mesh and export it again."""

    code = "scan.not_finite"


class CountsDiffer(BadInput):
    """The file holds other counts than it declares; export the mesh again."""

    code = "scan.counts"


class ExtentBroken(BadInput):
    """The mesh has no usable size; check what was exported."""

    code = "scan.extent"


class UnitsUnknown(BadInput):
    """The size fits neither metres, centimetres nor millimetres; say the file's unit with --units, or convert it."""

    code = "scan.units_unknown"


class StatureUnknown(BadInput):
    """The file has no unit in which this is a person; say with --height how high the person stands [m], or --units."""

    code = "scan.stature_unknown"


class UnitsAmbiguous(BadInput):
    """The size fits more than one unit; say which with --units m, cm, mm, inch or foot."""

    code = "scan.units_ambiguous"


class UpAmbiguous(BadInput):
    """Which axis points up is not clear; say which with --up y or z."""

    code = "scan.up_ambiguous"


class BodyApart(BadInput):
    """The garment does not lie on the body; export both from the same scene, with the same unit and axes."""

    code = "scan.body_apart"


class ChoiceBad(BadInput):
    """Units are m, cm, mm, inch or foot, and up is y or z; correct the option."""

    code = "scan.choice"


class LabelsMissing(BadInput):
    """The scan has neither labels nor colours to select the garment by; give a label file with --labels."""

    code = "scan.labels_missing"


class LabelsUnreadable(BadInput):
    """The label file cannot be read; save one integer or word per vertex as .npz, .npy, .json or .txt."""

    code = "scan.labels_unreadable"


class LabelsMismatch(BadInput):
    """There are more or fewer labels than vertices; give one label per vertex, in the order of the scan's file."""

    code = "scan.labels_mismatch"


class LabelUnknown(BadInput):
    """These labels do not separate the garment from the rest; correct --keep or --keep-colour."""

    code = "scan.label_unknown"


class PiecesTooMany(BadInput):
    """The surface is in thousands of pieces that are not joined; merge its vertices, and export it again."""

    code = "scan.pieces_too_many"


class ColourBad(BadInput):
    """The colour cannot be read; write it as '#465faa'."""

    code = "scan.colour"
