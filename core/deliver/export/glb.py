"""Write binary glTF: collect the arrays of a file, and pack them with their descriptions."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np

GL_FLOAT, GL_UNSIGNED_INT = 5126, 5125
"""Codes by OpenGL for the component types float32 and uint32, as glTF uses them."""

GL_ARRAY_BUFFER, GL_ELEMENT_ARRAY_BUFFER = 34962, 34963
"""Codes by OpenGL for the targets of a buffer view, vertex attributes and vertex indices, as glTF uses them."""

GLTF_ACCESSOR_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
"""glTF's names of vectors by their length."""


@dataclass
class GlbBuffer:
    """Collect the binary part of a GLB, its views and accessors."""

    content: bytearray = field(default_factory=bytearray)
    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)

    def add(self, values: np.ndarray, target: int | None = None, bounds: bool = False) -> int:
        """Add an array, shape [n] or [n, width], and return its accessor's index."""
        wide = values.shape[1] if values.ndim == 2 else 1
        accessor: dict[str, Any] = {
            "bufferView": self.add_bytes(values.tobytes(), target),
            "componentType": GL_UNSIGNED_INT if values.dtype.kind == "u" else GL_FLOAT,
            "count": len(values),
            "type": GLTF_ACCESSOR_TYPES[wide],
        }
        if bounds:
            accessor["min"] = np.atleast_1d(values.min(axis=0)).tolist()
            accessor["max"] = np.atleast_1d(values.max(axis=0)).tolist()
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def add_bytes(self, content: bytes, target: int | None = None) -> int:
        """Add a part at a multiple of four bytes, as arrays must be, and return its view's index."""
        self.content += b"\0" * (-len(self.content) % 4)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.content), "byteLength": len(content)}
        if target is not None:
            view["target"] = target
        self.content += content
        self.views.append(view)
        return len(self.views) - 1


def describe_scene(
    name: str,
    primitives: list[dict[str, Any]],
    materials: list[dict[str, Any]],
    extras: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """Return the description of a scene of one mesh, with `extras` of the mesh, as `pack_glb` takes it."""
    mesh: dict[str, Any] = {"name": name, "primitives": primitives}
    return {
        "asset": {"version": "2.0", "generator": "garmentq"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": name}],
        "meshes": [mesh if extras is None else mesh | {"extras": extras}],
        "materials": materials,
    }


def make_material(name: str, look: dict[str, Any]) -> dict[str, Any]:
    """Return a glTF material of matt cloth, seen from both sides; `look` has its colour or texture."""
    rough = {"metallicFactor": 0.0, "roughnessFactor": 0.9}
    return {"name": name, "doubleSided": True, "pbrMetallicRoughness": look | rough}


def pack_glb(scene: dict[str, Any], buffer: GlbBuffer) -> bytes:
    """Return a GLB of a scene with the collected accessors, views and buffer: two chunks of whole words."""
    scene = scene | {"accessors": buffer.accessors, "bufferViews": buffer.views}
    text = json.dumps(scene | {"buffers": [{"byteLength": len(buffer.content)}]}, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    content = bytes(buffer.content) + b"\0" * (-len(buffer.content) % 4)
    size = 12 + 8 + len(text) + 8 + len(content)
    return b"".join(
        [struct.pack("<III", 0x46546C67, 2, size), struct.pack("<II", len(text), 0x4E4F534A), text,
         struct.pack("<II", len(content), 0x004E4942), content]
    )  # fmt: skip
