"""Check the content of a glTF against its size: chunks, accessors, and that nothing refers to other files."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path
from typing import Any

from .limits import Limits
from .refusal import (
    ContentMismatch,
    CountTooLarge,
    ExtensionUnsupported,
    FileTooLarge,
    FileTruncated,
    HeaderBroken,
    OutsideReference,
)

_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_JSON_BYTES = 64 * 1024**2
"""Longest JSON that is read [bytes]; a garment's has a few KB, and in a .gltf all data besides."""
_EMBEDDED = re.compile(r"data:[\w./+-]*;base64,")
"""Beginning of data that are embedded in the JSON."""
_GLTF_TRIANGLES_MODE = 4
"""Code by glTF for separate triangles, the default."""
_HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_mesh_quantization", "EXT_texture_")
"""Required extensions that change only the appearance, or that keep plain accessors."""


def check_glb(path: Path, head: bytes, size: int, limits: Limits) -> tuple[None, int]:
    """Check a GLB's chunks and JSON; return None and the number of triangles it declares over all meshes.

    Vertices are not counted: a glTF splits them at texture seams and repeats them per node.

    Raises:
        BadInput: where anything is outside the file, too large, or missing.
    """
    name = path.name
    if head[:4] != b"glTF" or len(head) < 20:
        raise ContentMismatch(f"{name} does not begin like a GLB file; export the mesh again or rename the file.")
    version, length, json_bytes, kind = struct.unpack_from("<IIII", head, 4)
    if version != 2 or kind != 0x4E4F534A:
        raise HeaderBroken(f"{name} is no glTF 2 binary; export the mesh again.")
    if length > size or 20 + json_bytes > size:
        raise FileTruncated(f"{name} declares {length} bytes and holds {size}; export or copy it again.")
    if json_bytes > _JSON_BYTES:
        raise CountTooLarge(f"{name}: its JSON has {json_bytes >> 20} MiB; the file is damaged.")
    with path.open("rb") as file:
        file.seek(20)
        text = file.read(json_bytes)
    return _check_tree(name, text, size, limits)


def check_gltf(path: Path, head: bytes, size: int, limits: Limits) -> tuple[None, int]:
    """Check a .gltf that has all its data as base64 in its JSON; return what `check_glb` returns.

    Raises:
        BadInput: where anything is outside the file, too large, or missing.
    """
    if not head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        raise ContentMismatch(f"{path.name} does not begin like a glTF file; export the mesh again or rename the file.")
    if size > _JSON_BYTES:
        raise FileTooLarge(f"{path.name} has {size >> 20} MiB of text; export it as one .glb.")
    return _check_tree(path.name, path.read_bytes(), size, limits, holds_data=True)


def _check_tree(name: str, text: bytes, size: int, limits: Limits, holds_data: bool = False) -> tuple[None, int]:
    try:
        tree = json.loads(text)
        if not isinstance(tree, dict):
            raise ValueError("no object")
        _check_references(name, tree, ("buffers", "images") if holds_data else ("images",))
        if holds_data:
            _check_data(name, tree)
        _check_views(name, tree, size)
        _check_accessors(name, tree, limits)
        return None, _count_triangles(name, tree, limits)
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as error:
        raise HeaderBroken(f"{name}: the glTF JSON is not understood; export the mesh again.") from error


def _check_references(name: str, tree: dict[str, Any], embedded: tuple[str, ...]) -> None:
    """Check that nothing is in another file; groups of `embedded` may be base64 in the JSON."""
    for group in ("buffers", "images"):
        for entry in tree.get(group, []):
            if "uri" in entry and not (group in embedded and _EMBEDDED.match(str(entry["uri"]))):
                raise OutsideReference(
                    f"{name} points to '{str(entry['uri'])[:60]}'; export it as one GLB with everything embedded."
                )
    for extension in tree.get("extensionsRequired", []):
        if not str(extension).startswith(_HARMLESS):
            raise ExtensionUnsupported(f"{name} needs {extension}; export it as GLB without compression.")


def _check_data(name: str, tree: dict[str, Any]) -> None:
    """Check that each buffer in the JSON has its declared length."""
    for entry in tree.get("buffers", []):
        words = str(entry.get("uri", "")).partition("base64,")[2]
        if int(entry["byteLength"]) > len(words) * 3 // 4:
            raise FileTruncated(f"{name}: a buffer is shorter than it says; export the mesh again.")


def _check_views(name: str, tree: dict[str, Any], size: int) -> None:
    buffers = tree.get("buffers", [])
    for view in tree.get("bufferViews", []):
        end = int(view.get("byteOffset", 0)) + int(view["byteLength"])
        if view.get("byteOffset", 0) < 0 or end > int(buffers[int(view["buffer"])]["byteLength"]) or end > size:
            raise FileTruncated(f"{name}: a buffer view reaches beyond its buffer; export the mesh again.")


def _check_accessors(name: str, tree: dict[str, Any], limits: Limits) -> None:
    views = tree.get("bufferViews", [])
    for accessor in tree.get("accessors", []):
        count = int(accessor["count"])
        if not 0 <= count <= limits.count:
            raise CountTooLarge(f"{name} claims {count} elements in an accessor; the file is damaged.")
        if "bufferView" not in accessor:
            continue
        view = views[int(accessor["bufferView"])]
        width = _COMPONENT_BYTES[accessor["componentType"]] * _COMPONENTS[accessor["type"]]
        stride = int(view.get("byteStride", 0)) or width
        end = int(accessor.get("byteOffset", 0)) + stride * (count - 1) + width
        if count and end > int(view["byteLength"]):
            raise FileTruncated(f"{name}: an accessor of {count} elements reaches beyond its data; export it again.")


def _count_triangles(name: str, tree: dict[str, Any], limits: Limits) -> int:
    accessors = tree.get("accessors", [])
    total = 0
    for mesh in tree.get("meshes", []):
        for primitive in mesh["primitives"]:
            if primitive.get("mode", _GLTF_TRIANGLES_MODE) == _GLTF_TRIANGLES_MODE:
                of = primitive.get("indices", primitive["attributes"].get("POSITION"))
                total += 0 if of is None else int(accessors[int(of)]["count"]) // 3
    if total > limits.count:
        raise CountTooLarge(f"{name} claims {total} triangles, more than the {limits.count} read.")
    return total
