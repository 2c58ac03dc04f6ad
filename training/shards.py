"""Scans of simulated persons as files: what a scanner gave, and the truth beside it."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..core.people.points import PersonPoints
from ..core.scan.raw import RawScan
from .body_model import BodyModel

VERSION = 2
"""Layout of the files."""


@dataclass(frozen=True)
class Shard:
    """One scan of a simulated person.

    Attributes:
        points: Positions [m], y up, shape [n, 3].
        normals: Outward unit normals, shape [n, 3].
        faces: Triangles, shape [f, 3]; none for a cloud.
        label: `Part` numbers, uint8, shape [n].
        surface: Number of the surface of each point, uint8, shape [n]; `about["materials"]` has their materials.
        tightness: Distance to the true body [m], shape [n].
        border: Distance to the nearest point with another label [m], at most 0.1, shape [n].
        body_vertices: The true body, in the built-in body's topology [m], shape [m, 3].
        parameters: The true body's shape, pose and translation.
        about: Seed, person, scan, garments and scanner, for choosing and telling apart.
    """

    points: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    label: np.ndarray
    surface: np.ndarray
    tightness: np.ndarray
    border: np.ndarray
    body_vertices: np.ndarray
    parameters: dict[str, np.ndarray]
    about: dict[str, Any] = field(default_factory=dict)

    def raw_scan(self, name: str = "simulated") -> RawScan:
        """Return the scan as a loader would give it: in metres, y up, without colours and labels."""
        every = np.arange(len(self.points))
        return RawScan(self.points, self.faces, self.normals, True, None, None, every, every, name)

    def body_faces(self) -> np.ndarray:
        """Return the faces of the true body."""
        return BodyModel().faces


def save_shard(shard: Shard, path: Path) -> None:
    """Write a shard; a file that is there was written whole."""
    arrays = {f"parameters.{name}": value for name, value in shard.parameters.items()}
    started = path.with_suffix(".part")
    with started.open("wb") as file:
        np.savez_compressed(
            file,
            version=VERSION,
            points=shard.points.astype(np.float32),
            normals=np.round(127 * shard.normals).astype(np.int8),
            faces=shard.faces.astype(np.int32),
            label=shard.label.astype(np.uint8),
            surface=shard.surface.astype(np.uint8),
            tightness=shard.tightness.astype(np.float16),
            border=shard.border.astype(np.float16),
            body_vertices=shard.body_vertices.astype(np.float32),
            about=json.dumps(shard.about),
            **arrays,
        )
    started.replace(path)


def nearest_points(points: PersonPoints, shard: Shard) -> np.ndarray:
    """Return the scan's point nearest to each sample, one that faces alike before one that does not, shape [n]."""
    length = 0.01
    tree = cKDTree(np.hstack([shard.points, length * shard.normals]))
    return np.asarray(tree.query(np.hstack([points.positions, length * points.normals]))[1])


def load_shard(path: Path) -> Shard:
    """Read a shard."""
    with np.load(path) as kept:
        normals = kept["normals"].astype(np.float64)
        return Shard(
            points=kept["points"].astype(np.float64),
            normals=normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9),
            faces=kept["faces"].astype(np.int64),
            label=kept["label"],
            surface=kept["surface"],
            tightness=kept["tightness"].astype(np.float64),
            border=kept["border"].astype(np.float64),
            body_vertices=kept["body_vertices"].astype(np.float64),
            parameters={k.removeprefix("parameters."): kept[k] for k in kept.files if k.startswith("parameters.")},
            about=json.loads(str(kept["about"])),
        )
