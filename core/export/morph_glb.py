"""Write a garment in motion as GLB: one mesh with a morph target for each frame, and an animation that plays them."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..mesh import vertex_normals
from ..pattern import Garment
from .meshes import uv_layout

MOST_BYTES = 200_000_000
"""Size of a file at most: beyond, the caches are for it; viewers keep all targets in memory."""

FLOAT, UNSIGNED = 5126, 5125
"""glTF's names of float32 and uint32."""

VERTICES, INDICES = 34962, 34963
"""glTF's names of what a buffer's part is for."""


@dataclass
class _Buffer:
    """Collect the binary part of a GLB and what describes it."""

    content: bytearray = field(default_factory=bytearray)
    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)

    def add(self, values: np.ndarray, target: int | None = None, bounds: bool = False) -> int:
        """Add an array, shape [n] or [n, width], and return its accessor's index."""
        wide = values.shape[1] if values.ndim == 2 else 1
        kind = UNSIGNED if values.dtype.kind == "u" else FLOAT
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.content), "byteLength": values.nbytes}
        if target is not None:
            view["target"] = target
        accessor: dict[str, Any] = {
            "bufferView": len(self.views),
            "componentType": kind,
            "count": len(values),
            "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3"}[wide],
        }
        if bounds:
            accessor["min"] = np.atleast_1d(values.min(axis=0)).tolist()
            accessor["max"] = np.atleast_1d(values.max(axis=0)).tolist()
        self.content += values.tobytes()
        self.views.append(view)
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def morph_bytes(garment: Garment, frames: np.ndarray) -> int:
    """Return about how large the file of some frames, shape [frame_count, node_count, 3], is [bytes]."""
    return 12 * len(frames) * len(garment.uv_node) + 4 * len(frames) ** 2


def write_morphs(garment: Garment, frames: np.ndarray, fps: float, path: Path) -> Path:
    """Write frames [m], shape [frame_count, node_count, 3], as a GLB, split along the seams, y up.

    The mesh is the first frame; target n is the difference of frame n to it, and the animation gives each target its
    whole weight at its own time and none at its neighbours', so that viewers interpolate between two frames.
    """
    split, buffer = garment.uv_node, _Buffer()
    first = frames[0][split].astype("<f4")
    uv = uv_layout(garment)
    uv[:, 1] = 1.0 - uv[:, 1]  # a glTF's v runs downwards
    attributes = {
        "POSITION": buffer.add(first, VERTICES, bounds=True),
        "NORMAL": buffer.add(vertex_normals(frames[0], garment.faces)[split].astype("<f4"), VERTICES),
        "TEXCOORD_0": buffer.add(uv.astype("<f4"), VERTICES),
    }
    faces = buffer.add(garment.uv_faces.astype("<u4").ravel(), INDICES)
    targets = [
        {"POSITION": buffer.add((frame[split] - frames[0][split]).astype("<f4"), VERTICES, bounds=True)}
        for frame in frames[1:]
    ]
    mesh: dict[str, Any] = {
        "primitives": [{"attributes": attributes, "indices": faces, "material": 0}],
        "name": "cloth",
    }
    scene: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "garmentq"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "garment"}],
        "meshes": [mesh],
        "materials": [
            {
                "name": "cloth",
                "doubleSided": True,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.59, 0.67, 0.75, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9,
                },
            }
        ],
    }  # fmt: skip
    if targets:
        mesh["primitives"][0]["targets"] = targets
        mesh["weights"] = [0.0] * len(targets)
        times = buffer.add((np.arange(len(frames)) / fps).astype("<f4"), bounds=True)
        weights = buffer.add(np.eye(len(frames), dtype="<f4")[:, 1:].ravel())
        scene["animations"] = [
            {
                "name": "motion",
                "samplers": [{"input": times, "output": weights, "interpolation": "LINEAR"}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            }
        ]
    scene |= {"accessors": buffer.accessors, "bufferViews": buffer.views}
    scene["buffers"] = [{"byteLength": len(buffer.content)}]
    path.write_bytes(_pack(scene, bytes(buffer.content)))
    return path


def _pack(scene: dict[str, Any], content: bytes) -> bytes:
    """Return the two chunks of a GLB, each padded to four bytes."""
    text = json.dumps(scene, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    content += b"\0" * (-len(content) % 4)
    size = 12 + 8 + len(text) + 8 + len(content)
    return b"".join(
        [struct.pack("<III", 0x46546C67, 2, size), struct.pack("<II", len(text), 0x4E4F534A), text,
         struct.pack("<II", len(content), 0x004E4942), content]
    )  # fmt: skip
