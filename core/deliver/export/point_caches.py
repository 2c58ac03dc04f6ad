"""Write node positions over time as point caches: PC2 and MDD, which Blender, Maya, Houdini and others play."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np


def write_pc2(frames: np.ndarray, path: Path) -> Path:
    """Write frames [m], shape [frame_count, node_count, 3], as PC2: float32, y up, one sample a frame from frame 0.
    Header, little endian: `POINTCACHE2`, 0, version 1, points, first frame, frames a sample, samples; then x, y, z."""
    frames = np.asarray(frames)
    header = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, frames.shape[1], 0.0, 1.0, len(frames))
    path.write_bytes(header + frames.astype("<f4").tobytes())
    return path


def write_mdd(frames: np.ndarray, fps: float, path: Path) -> Path:
    """Write frames [m], shape [frame_count, node_count, 3], as MDD: float32, y up, with the time of each frame [s].
    Header, big endian: frames, points, times; then x, y, z."""
    frames = np.asarray(frames)
    header = struct.pack(">ii", len(frames), frames.shape[1])
    times = (np.arange(len(frames)) / fps).astype(">f4")
    path.write_bytes(header + times.tobytes() + frames.astype(">f4").tobytes())
    return path
