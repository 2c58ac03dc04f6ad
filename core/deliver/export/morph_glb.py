"""Write a garment in motion as GLB: one mesh with a morph target for each frame, and an animation that plays them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...garment.garment import Garment
from ...geometry.geometry import vertex_normals
from .glb import GL_ARRAY_BUFFER, GL_ELEMENT_ARRAY_BUFFER, GlbBuffer, pack_glb
from .meshes import uv_layout

MAX_ANIMATION_FILE_BYTES = 200_000_000
"""Largest size of an animation's file [bytes]; viewers load all of it. Larger motions are in the point caches."""


def morph_bytes(garment: Garment, frames: np.ndarray) -> int:
    """Estimate the size of the file of some frames, shape [frame_count, node_count, 3] [bytes]."""
    return 12 * len(frames) * len(garment.uv_node) + 4 * len(frames) ** 2


def write_morphs(garment: Garment, frames: np.ndarray, fps: float, path: Path) -> Path:
    """Write frames [m], shape [frame_count, node_count, 3], as a GLB, split along the seams, y up. The mesh is the
    first frame; target n is the difference of frame n to it. The animation gives each target its whole weight at its
    own time and none at its neighbours', so that viewers interpolate between two frames."""
    split, buffer = garment.uv_node, GlbBuffer()
    first = frames[0][split].astype("<f4")
    uv = uv_layout(garment)
    uv[:, 1] = 1.0 - uv[:, 1]  # a glTF's v runs downwards
    attributes = {
        "POSITION": buffer.add(first, GL_ARRAY_BUFFER, bounds=True),
        "NORMAL": buffer.add(vertex_normals(frames[0], garment.faces)[split].astype("<f4"), GL_ARRAY_BUFFER),
        "TEXCOORD_0": buffer.add(uv.astype("<f4"), GL_ARRAY_BUFFER),
    }
    faces = buffer.add(garment.uv_faces.astype("<u4").ravel(), GL_ELEMENT_ARRAY_BUFFER)
    targets = [
        {"POSITION": buffer.add((frame[split] - frames[0][split]).astype("<f4"), GL_ARRAY_BUFFER, bounds=True)}
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
    path.write_bytes(pack_glb(scene, buffer))
    return path
