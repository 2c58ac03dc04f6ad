"""Write a garment in motion as GLB: one mesh with a morph target for each frame, and an animation that plays them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...garment.garment import Garment
from .glb import GL_ARRAY_BUFFER, GlbBuffer, describe_scene, make_material, pack_glb
from .meshes import CLOTH_LOOK, add_split_mesh

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
    primitive = add_split_mesh(garment, frames[0], buffer)
    targets = [
        {"POSITION": buffer.add((frame[split] - frames[0][split]).astype("<f4"), GL_ARRAY_BUFFER, bounds=True)}
        for frame in frames[1:]
    ]
    scene = describe_scene("garment", [primitive], [make_material("cloth", CLOTH_LOOK)])
    if targets:
        primitive["targets"] = targets
        scene["meshes"][0]["weights"] = [0.0] * len(targets)
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
