"""Read what a file declares without a mesh library, and check it against the file's size before it is parsed."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path

from .cloud_header import check_pcd, check_xyz
from .glb import check_glb, check_gltf
from .head import INITIAL_HEAD_BYTES, read_head
from .limits import Limits
from .refusal import (
    ArchiveRefused,
    ContentMismatch,
    CountTooLarge,
    FileMissing,
    FileTooLarge,
    FileTruncated,
    FormatUnknown,
    HeaderBroken,
    MeshEmpty,
    NoFaces,
)

_ARCHIVES = (
    b"PK\x03\x04",
    b"PK\x05\x06",
    b"\x1f\x8b",
    b"7z\xbc\xaf",
    b"Rar!",
    b"BZh",
    b"\xfd7zXZ",
    b"\x28\xb5\x2f\xfd",
)
_PLY_SIZES = {
    "char": 1, "uchar": 1, "int8": 1, "uint8": 1, "short": 2, "ushort": 2, "int16": 2, "uint16": 2,
    "int": 4, "uint": 4, "int32": 4, "uint32": 4, "float": 4, "float32": 4, "double": 8, "float64": 8,
}  # fmt: skip
_TAIL_BYTES = 1 << 20
"""Length of an STL's end that is searched for `endsolid` [bytes]: its name, of any length, may follow."""
PLY_END = re.compile(rb"\nend_header[ \t]*\r?\n")


@dataclass(frozen=True)
class DeclaredContent:
    """Describe the content that a file declares.

    Attributes:
        format: One of `FORMATS` or `CLOUDS`; of a .gltf `glb`, since the content is the same.
        vertices: Number of vertices, or None where the format does not say.
        faces: Number of faces (polygons), or None where the format does not say.
    """

    format: str
    vertices: int | None = None
    faces: int | None = None


def check_header(path: Path, limits: Limits, needs_faces: bool = True) -> DeclaredContent:
    """Check extension, magic, size and declared counts of a file before it is parsed.

    Args:
        path: The file.
        limits: What reading may cost.
        needs_faces: Whether points without faces are refused; a person's scan may be a cloud, a garment's not.

    Raises:
        BadInput: a subclass in `refusal` where the file is not acceptable.
    """
    if not path.is_file():
        raise FileMissing(f"{path} is not a file; check the path.")
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(INITIAL_HEAD_BYTES)
    extension = path.suffix.lower().lstrip(".")
    if extension in _CHECKS and any(head.startswith(magic) for magic in _ARCHIVES):
        raise ArchiveRefused(f"{path.name} is an archive named .{extension}; unpack it and give the mesh file inside.")
    check_extension(path)
    if size > limits.file_bytes:
        limit = limits.file_bytes >> 20
        raise FileTooLarge(f"{path.name} has {size >> 20} MiB, more than the {limit} MiB read; decimate the mesh.")
    if size == 0:
        raise MeshEmpty(f"{path.name} is an empty file; export the mesh again.")
    declared = _CHECKS[extension](path, head, size, limits)
    if needs_faces and declared.faces == 0:
        raise NoFaces(
            f"{path.name} holds points without faces, which only a whole person may be; give a garment as a mesh."
        )
    return declared


def check_extension(path: Path) -> None:
    """Check that a mesh file's name ends in one of the accepted extensions.

    Raises:
        ArchiveRefused, FormatUnknown: where it does not.
    """
    name, extension = path.name, path.suffix.lower().lstrip(".")
    if extension in _CHECKS:
        return
    accepted = ", ".join(_CHECKS).upper()
    if extension in ("zip", "3mf", "usdz", "gz", "7z", "rar", "tar", "tgz", "bz2", "xz", "zst"):
        raise ArchiveRefused(f"{name} is an archive (.{extension}); give a mesh file instead ({accepted}).")
    raise FormatUnknown(f"{name}: files of type .{extension or '?'} are not read; export the mesh as {accepted}.")


def _check_count(name: str, count: int, what: str, limits: Limits) -> None:
    if count < 0:
        raise HeaderBroken(f"{name} claims {count} {what}; export the mesh again.")
    if count > limits.count:
        raise CountTooLarge(
            f"{name} claims {count} {what}, more than the {limits.count} read; it is damaged or must be decimated."
        )


def _check_ply(path: Path, head: bytes, size: int, limits: Limits) -> DeclaredContent:
    if re.match(rb"ply\s", head) is None:
        raise ContentMismatch(f"{path.name} does not begin like a PLY file; export the mesh again or rename the file.")
    head = read_head(path, PLY_END)
    end = PLY_END.search(head)
    if end is None:
        raise HeaderBroken(f"{path.name}: the PLY header does not end; the file is damaged.")
    lines = head[: end.start()].decode("latin-1").splitlines()
    if any(line.split()[-1:] == ["packed_position"] for line in lines):
        raise FormatUnknown(f"{path.name} is a compressed Gaussian splat, which is not read; export it uncompressed.")
    form, elements = _read_ply_header(path.name, lines)
    counts = dict.fromkeys(("vertex", "face"), 0)
    body = size - end.end()
    minimum = 0
    for name, count, stride in elements:
        _check_count(path.name, count, f"{name} elements", limits)
        counts[name] = count
        minimum += count * stride
    if form == "ascii":
        rows = sum(count for _, count, stride in elements if stride)
        found = _count_lines(path, end.end(), rows)
        if found < rows:
            raise FileTruncated(f"{path.name} declares {rows} rows and holds {found}; export or copy it again.")
    elif minimum > body:
        raise FileTruncated(f"{path.name} needs at least {minimum} bytes of data and holds {body}; copy it again.")
    if counts["vertex"] == 0:
        raise MeshEmpty(f"{path.name} holds no vertices; export the mesh again.")
    return DeclaredContent("ply", counts["vertex"], counts["face"])


def _read_ply_header(name: str, lines: list[str]) -> tuple[str, list[tuple[str, int, int]]]:
    """Read a PLY header: the format, and per element its name, count and least bytes of one binary row."""
    form = ""
    elements: list[tuple[str, int, int]] = []
    for line in lines[1:]:
        words = line.split()
        if not words or words[0] in ("comment", "obj_info"):
            continue
        try:
            if words[0] == "format":
                form = {"ascii": "ascii", "binary_little_endian": "binary", "binary_big_endian": "binary"}[words[1]]
            elif words[0] == "element":
                if words[1] in [e[0] for e in elements]:
                    raise HeaderBroken(f"{name}: element {words[1]} is declared twice; export the mesh again.")
                elements.append((words[1], int(words[2]), 0))
            elif words[0] == "property":
                owner, count, stride = elements.pop()
                # An empty list is its count alone; a face has at least three indices.
                least = 3 if owner == "face" and words[-1] in ("vertex_indices", "vertex_index") else 0
                is_list = words[1] == "list"
                stride += _PLY_SIZES[words[2]] + least * _PLY_SIZES[words[3]] if is_list else _PLY_SIZES[words[1]]
                elements.append((owner, count, stride))
            else:
                raise KeyError(words[0])
        except (KeyError, IndexError, ValueError) as error:
            raise HeaderBroken(f"{name}: PLY header line '{line.strip()[:60]}' is not understood.") from error
    if not form:
        raise HeaderBroken(f"{name}: the PLY header names no format; the file is damaged.")
    return form, elements


def _count_lines(path: Path, start: int, enough: int) -> int:
    """Count lines that are not empty from an offset on, up to `enough`."""
    found = 0
    with path.open("rb") as file:
        file.seek(start)
        for line in file:
            found += bool(line.strip())
            if found >= enough:
                break
    return found


def _check_stl(path: Path, head: bytes, size: int, limits: Limits) -> DeclaredContent:
    count = struct.unpack_from("<I", head, 80)[0] if len(head) >= 84 else -1
    if size == 84 + 50 * count:
        _check_count(path.name, count, "triangles", limits)
        if count == 0:
            raise NoFaces(f"{path.name} holds no triangles; export the mesh again.")
        return DeclaredContent("stl", None, count)
    if head.lstrip()[:5].lower() == b"solid" and b"\0" not in head:
        if not _has_facet(path):
            raise NoFaces(f"{path.name} holds no triangles; export the mesh again.")
        if b"endsolid" not in _read_tail(path, size):
            raise FileTruncated(f"{path.name} breaks off before 'endsolid'; export or copy it again.")
        return DeclaredContent("stl")
    if count < 0 or _is_text(head):
        raise ContentMismatch(f"{path.name} is no STL file; export the mesh again or rename the file.")
    _check_count(path.name, count, "triangles", limits)
    if size < 84 + 50 * count:
        present = (size - 84) // 50
        raise FileTruncated(f"{path.name} declares {count} triangles and holds {present}; export or copy it again.")
    return DeclaredContent("stl", None, count)


def _has_facet(path: Path) -> bool:
    with path.open("rb") as file:
        return any(re.search(rb"\bfacet\b", line) for line in file)


def _is_text(head: bytes) -> bool:
    return all(byte in b"\t\n\r\f" or 32 <= byte < 127 for byte in head[:4096])


def _read_tail(path: Path, size: int) -> bytes:
    with path.open("rb") as file:
        file.seek(max(0, size - _TAIL_BYTES))
        return file.read().lower()


def _check_off(path: Path, head: bytes, size: int, limits: Limits) -> DeclaredContent:
    words: list[bytes] = []
    with path.open("rb") as file:
        for line in file:
            words += line.split(b"#")[0].split()
            if len(words) >= 3 or not {b"OFF", b"COFF"}.issuperset(words[:1]):
                break
    if not words or words[0] not in (b"OFF", b"COFF"):
        raise ContentMismatch(f"{path.name} does not begin like an OFF file; export the mesh again or rename the file.")
    try:
        vertices, faces = int(words[1]), int(words[2])
    except (IndexError, ValueError) as error:
        raise HeaderBroken(f"{path.name}: the OFF counts are not numbers; the file is damaged.") from error
    _check_count(path.name, vertices, "vertices", limits)
    _check_count(path.name, faces, "faces", limits)
    if vertices == 0:
        raise MeshEmpty(f"{path.name} holds no vertices; export the mesh again.")
    # Three one-digit numbers with separators per vertex, four per face.
    if 6 * vertices + 8 * faces > size or _count_lines(path, 0, vertices + faces) < vertices + faces:
        raise FileTruncated(f"{path.name} holds fewer rows than it declares; export or copy it again.")
    return DeclaredContent("off", vertices, faces)


def _check_obj(path: Path, head: bytes, size: int, limits: Limits) -> DeclaredContent:
    # OBJ has no magic: it is text that holds a vertex, perhaps behind all texture coordinates and normals.
    vertices = faces = 0
    with path.open("rb") as file:
        for line in file if b"\0" not in head else ():
            word = line[:3].lstrip()[:2]
            vertices += word in (b"v ", b"v\t")
            faces += word in (b"f ", b"f\t")
    if vertices == 0:
        raise ContentMismatch(f"{path.name} holds no OBJ vertices; export the mesh again or rename the file.")
    _check_count(path.name, vertices, "vertices", limits)
    _check_count(path.name, faces, "faces", limits)
    return DeclaredContent("obj", vertices, faces)


def _check_glb(path: Path, head: bytes, size: int, limits: Limits) -> DeclaredContent:
    check = check_gltf if path.suffix.lower() == ".gltf" else check_glb
    vertices, faces = check(path, head, size, limits)
    return DeclaredContent("glb", vertices, faces)


def _check_cloud(path: Path, head: bytes, size: int, limits: Limits) -> DeclaredContent:
    if path.suffix.lower() == ".xyz":
        check_xyz(path, head)
        return DeclaredContent("xyz", None, 0)
    count = check_pcd(path, size)
    _check_count(path.name, count, "points", limits)
    if count == 0:
        raise MeshEmpty(f"{path.name} holds no points; export the scan again.")
    return DeclaredContent("pcd", count, 0)


FORMATS = {
    "ply": _check_ply, "obj": _check_obj, "stl": _check_stl, "off": _check_off, "glb": _check_glb, "gltf": _check_glb,
}  # fmt: skip
"""Check of each accepted extension of a mesh; the content must agree. `parse` reads them."""
CLOUDS = {"pcd": _check_cloud, "xyz": _check_cloud}
"""Check of each accepted extension of a file of points alone."""
_CHECKS = FORMATS | CLOUDS
