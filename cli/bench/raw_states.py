"""Degrade a raw scan as other scanners and exporters would, to measure how robust the labelling is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...core.geometry.surface import TriangleSurface
from ...core.scan.repair import repair_surface
from .damage import HOLE_RADII, cut_holes
from .raw_file import RawFile

POINT_NOISE_STD = 0.005
"""Standard deviation of the noise in each coordinate [m]: five times a studio scanner's, a phone's at arm's length."""

HOLE_AREA_SHARE = 0.10
"""Share of the surface that is lost in the state with holes."""

DECIMATED_VERTEX_COUNT = 10_000
"""Number of vertices of a scan that was decimated for the web."""

DRAWN_CLOUD_POINT_COUNT = 50_000
"""Number of points of a cloud: a person then has one every 6 mm."""


@dataclass(frozen=True)
class ScanState:
    """Describe one state of a raw scan.

    Attributes:
        name: Stable name, `noise_5mm`.
        text: Description, for a table.
        apply: From the file, with positions in metres, its labels and a generator, to the degraded file and its labels.
    """

    name: str
    text: str
    apply: Callable[[RawFile, np.ndarray, np.random.Generator], tuple[RawFile, np.ndarray]]


def degrade_scan(
    raw: RawFile, labels: np.ndarray, state: ScanState, metre: float, seed: int = 0
) -> tuple[RawFile, np.ndarray]:
    """Bring a file into a state; the same seed gives the same file.

    Args:
        raw: The scan as it is.
        labels: True label of each of its points, shape [n].
        state: The state.
        metre: Metres in one unit of the file.
        seed: Seed of the random numbers.
    """
    in_metres = replace(raw, points=metre * raw.points)
    worse, kept = state.apply(in_metres, labels, np.random.default_rng(seed))
    return replace(worse, points=worse.points / metre), kept


def _keep_unchanged(raw: RawFile, labels: np.ndarray, rng: np.random.Generator) -> tuple[RawFile, np.ndarray]:
    return raw, labels


def _add_noise(raw: RawFile, labels: np.ndarray, rng: np.random.Generator) -> tuple[RawFile, np.ndarray]:
    """Move every point; normals are dropped, because they would still be those of the smooth surface."""
    return replace(raw, points=raw.points + rng.normal(0.0, POINT_NOISE_STD, raw.points.shape), normals=None), labels


def _cut_holes(raw: RawFile, labels: np.ndarray, rng: np.random.Generator) -> tuple[RawFile, np.ndarray]:
    if len(raw.faces):
        _, faces = cut_holes(HOLE_AREA_SHARE)(raw.points, raw.faces, rng)
        kept = np.unique(faces)
        return replace(raw, faces=faces).take(kept), labels[kept]
    left = np.ones(len(raw.points), bool)
    while left.mean() > 1.0 - HOLE_AREA_SHARE:
        place = raw.points[rng.integers(len(raw.points))]
        left &= np.linalg.norm(raw.points - place, axis=1) > rng.uniform(*HOLE_RADII)
    kept = np.flatnonzero(left)
    return raw.take(kept), labels[kept]


def _drop_colours(raw: RawFile, labels: np.ndarray, rng: np.random.Generator) -> tuple[RawFile, np.ndarray]:
    return replace(raw, colours=None), labels


def _decimate(raw: RawFile, labels: np.ndarray, rng: np.random.Generator) -> tuple[RawFile, np.ndarray]:
    """Collapse a mesh's edges by quadric error to `DECIMATED_VERTEX_COUNT` vertices; draw as many points of a cloud."""
    if not len(raw.faces):
        kept = np.sort(rng.choice(len(raw.points), min(DECIMATED_VERTEX_COUNT, len(raw.points)), replace=False))
        return raw.take(kept), labels[kept]
    points, faces = _collapse(raw.points, raw.faces, DECIMATED_VERTEX_COUNT)
    _, nearest = cKDTree(raw.points).query(points)
    colours = None if raw.colours is None else raw.colours[nearest]
    return RawFile(points, faces, None, colours), labels[nearest]


def _collapse(points: np.ndarray, faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Collapse edges until about `count` vertices are left: a closed surface has two faces a vertex."""
    import igl

    whole = repair_surface(points, faces)  # the collapse needs a manifold
    corners = np.asfortranarray(whole.faces, np.int32)
    points, faces, *_ = igl.qslim(np.asfortranarray(whole.vertices), corners, 2 * count, False)
    used = np.unique(faces)
    place = np.zeros(len(points), dtype=np.int64)
    place[used] = np.arange(len(used))
    return points[used], place[faces]


def _to_cloud(raw: RawFile, labels: np.ndarray, rng: np.random.Generator) -> tuple[RawFile, np.ndarray]:
    """Draw points evenly from the surface, or of the points of a cloud; normals are dropped."""
    if not len(raw.faces):
        kept = np.sort(rng.choice(len(raw.points), min(DRAWN_CLOUD_POINT_COUNT, len(raw.points)), replace=False))
        return replace(raw.take(kept), normals=None), labels[kept]
    points, face = TriangleSurface(raw.points, raw.faces).sample(DRAWN_CLOUD_POINT_COUNT, rng)
    corners = raw.faces[face]
    nearest = np.argmin(np.linalg.norm(raw.points[corners] - points[:, None], axis=2), axis=1)
    vertex = corners[np.arange(len(corners)), nearest]
    colours = None if raw.colours is None else raw.colours[vertex]
    return RawFile(points, np.zeros((0, 3), np.int64), None, colours), labels[vertex]


SCAN_STATES = (
    ScanState("as_is", "nothing", _keep_unchanged),
    ScanState("noise_5mm", "Gaussian noise of 5 mm in every coordinate, no normals", _add_noise),
    ScanState("holes_10", "10 % of the surface lost in holes of 2 to 5 cm radius", _cut_holes),
    ScanState("no_colours", "colours dropped", _drop_colours),
    ScanState("decimated_10k", "decimated to 10 000 vertices", _decimate),
    ScanState("cloud_50k", "50 000 points of the surface, without normals", _to_cloud),
)
"""Every state; the first is the scan unchanged."""
