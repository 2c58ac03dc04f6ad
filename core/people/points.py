"""Sample a person's raw scan evenly, meshes and clouds alike; the samples are what is labelled."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..geometry.geometry import unit, vertex_normals
from ..geometry.point_normals import denoise_normals, estimate_normals, orient_normals
from ..geometry.surface import TriangleSurface, barycentric_coordinates
from ..run.kernels import kernel
from ..scan.raw import RawScan
from .lab import to_lab

MIN_SAMPLE_SPACING = 0.007
"""Least distance between two samples [m]: a cuff's hem of 2 cm still has three, and a person about 25,000."""
MAX_SAMPLE_COUNT = 30_000
"""Largest number of samples: beyond it the spacing grows, so that time does not depend on the scan."""
CANDIDATES_PER_SAMPLE = 6
"""Number of candidates for each sample: their mean more than halves the scanner's noise of one point."""
MAX_CANDIDATE_COUNT = 400_000
"""Largest number of a cloud's points that become candidates: 16 for each sample."""
SAMPLE_MATCH_NORMAL_LENGTH = 0.008
"""Length that a unit of difference in normals counts as when samples are matched to the scan's points [m]: two layers
that face away from each other are then never nearer than 16 mm."""
MAX_GRID_CELL_COUNT = 8_000_000
"""Largest number of cells of the search grid, 32 MB: an outlier far away makes the cells larger, not the memory."""
INTERPOLATION_SAMPLE_COUNT = 3
"""Number of samples from which a value at a point of the file is interpolated: the corners of a triangle around it."""


class FittedPerson(Protocol):
    """Describe a body fitted to a person: all that samples and features need of it."""

    @property
    def body(self) -> Body:
        """Return the wearer, in the scan's place and pose."""
        ...


@dataclass(frozen=True)
class PersonPoints:
    """Describe even samples of a raw scan, and how values at them are interpolated.

    Attributes:
        positions: Positions [m], shape [n, 3].
        normals: Outward unit normals, shape [n, 3].
        colours: RGB in 0..1, shape [n, 3], or None.
        spacing: Least distance of two samples [m].
        border: Distance to the scan's border, of holes too [m], at most `MAX_SAMPLE_BORDER_DISTANCE`, shape [n].
        nearest: Samples between which each point of the raw scan is, int32, shape [m, 3].
        weights: Their weights, rows sum to 1, float32, shape [m, 3].
    """

    positions: np.ndarray
    normals: np.ndarray
    colours: np.ndarray | None
    spacing: float
    border: np.ndarray
    nearest: np.ndarray
    weights: np.ndarray

    @cached_property
    def lab(self) -> np.ndarray | None:
        """Return the colours in L*a*b*, shape [n, 3], or None."""
        return None if self.colours is None else to_lab(self.colours)

    def carry(self, values: np.ndarray) -> np.ndarray:
        """Interpolate values at the samples, shape [n, k], to the raw scan's points, shape [m, k]."""
        weights = self.weights.astype(values.dtype)
        return np.asarray(
            sum(weights[:, k, None] * values[self.nearest[:, k]] for k in range(INTERPOLATION_SAMPLE_COUNT))
        )


MAX_SAMPLE_BORDER_DISTANCE = 0.1
"""Upper bound of the distance to the border [m]: farther away the border has no influence on a point."""
BORDER_GAP_ANGLE = np.radians(120)
"""Angle around a sample without neighbours beyond which it is on the border [rad]: 180 degrees along a straight border,
and below 90 degrees inside an even sampling."""


def sample_person(raw: RawScan, fit: FittedPerson, seed: int = 0) -> PersonPoints:
    """Sample a raw scan evenly.

    Candidates are drawn uniformly by area (of a cloud its points are), taken in random order where no sample of their
    side is nearer than the spacing (dart throwing), and each sample then moves to the mean of its candidates.

    Args:
        raw: The scan; a cloud's normals are estimated if missing, and oriented by the body's if unoriented.
        fit: The body fitted to it.
        seed: Seed of the draw; the same scan and seed give the same samples.
    """
    rng = np.random.default_rng(seed)
    positions, normals, colours = _draw_candidates(raw, fit.body, rng)
    spacing = MIN_SAMPLE_SPACING
    owner, chosen = _assign_to_samples(positions, normals, spacing)
    while len(chosen) > MAX_SAMPLE_COUNT:
        spacing *= 1.05 * np.sqrt(len(chosen) / MAX_SAMPLE_COUNT)
        owner, chosen = _assign_to_samples(positions, normals, spacing)
    count = np.bincount(owner, minlength=len(chosen))[:, None]

    def average(values: np.ndarray) -> np.ndarray:
        return np.stack([np.bincount(owner, column, len(chosen)) for column in values.T], axis=1) / count

    centres, outward = average(positions), unit(average(normals))
    outward = np.where(np.isfinite(outward).all(axis=1, keepdims=True), outward, normals[chosen])
    outward = denoise_normals(centres, outward)
    nearest, weights = _interpolation_weights(centres, outward, raw)
    return PersonPoints(
        positions=centres,
        normals=outward,
        colours=None if colours is None else average(colours),
        spacing=spacing,
        border=_border_distance(centres, outward, spacing),
        nearest=nearest,
        weights=weights,
    )


def _draw_candidates(
    raw: RawScan, body: Body, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Draw positions [m], outward normals and colours, each of shape [c, 3], in random order."""
    if raw.is_cloud:
        take = rng.permutation(len(raw.points))[:MAX_CANDIDATE_COUNT]
        positions = raw.points[take]
        normals = estimate_normals(positions) if raw.normals is None else raw.normals[take]
        if raw.normals is None or not raw.is_oriented:
            normals = orient_normals(positions, normals, body.vertices, vertex_normals(body.vertices, body.faces))
        return positions, normals, None if raw.colours is None else raw.colours[take]
    surface = TriangleSurface(raw.points, raw.faces)
    count = int(
        np.clip(CANDIDATES_PER_SAMPLE * surface.face_areas.sum() / MIN_SAMPLE_SPACING**2, 100, MAX_CANDIDATE_COUNT)
    )
    positions, face = surface.sample(count, rng)
    shuffle = rng.permutation(count)
    positions, corners = positions[shuffle], raw.faces[face[shuffle]]
    share = barycentric_coordinates(positions, raw.points[corners])
    at_vertices = vertex_normals(raw.points, raw.faces)
    normals = unit(np.einsum("nk,nkd->nd", share, at_vertices[corners]))
    colours = None if raw.colours is None else np.einsum("nk,nkd->nd", share, raw.colours[corners])
    return positions, normals, colours


def _assign_to_samples(positions: np.ndarray, normals: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return each candidate's sample, shape [c], and the candidate that each sample was, shape [n]."""
    low = positions.min(axis=0)
    extent = np.ptp(positions, axis=0)
    cell = max(spacing, float(np.prod(extent + spacing) / MAX_GRID_CELL_COUNT) ** (1 / 3))
    shape = np.floor(extent / cell).astype(np.int64) + 1
    place = np.floor((positions - low) / cell).astype(np.int64)
    owner, chosen = _throw_darts(positions, normals, place, shape, spacing**2)
    return owner, chosen


@kernel()
def _throw_darts(positions, normals, place, shape, square):  # type: ignore[no-untyped-def]
    """Take each candidate without a near sample of its side; then assign every candidate to the nearest sample."""
    count = len(positions)
    head = np.full(shape[0] * shape[1] * shape[2], -1, dtype=np.int32)
    link = np.full(count, -1, dtype=np.int32)
    number = np.full(count, -1, dtype=np.int64)
    chosen = np.zeros(count, dtype=np.int64)
    owner = np.full(count, -1, dtype=np.int64)
    found = 0
    for turn in range(2):
        for i in range(count):
            nearest, at = square, -1
            for x in range(max(place[i, 0] - 1, 0), min(place[i, 0] + 2, shape[0])):
                for y in range(max(place[i, 1] - 1, 0), min(place[i, 1] + 2, shape[1])):
                    for z in range(max(place[i, 2] - 1, 0), min(place[i, 2] + 2, shape[2])):
                        j = head[(x * shape[1] + y) * shape[2] + z]
                        while j >= 0:
                            distance, side = 0.0, 0.0
                            for a in range(3):
                                distance += (positions[i, a] - positions[j, a]) ** 2
                                side += normals[i, a] * normals[j, a]
                            if distance < nearest and side > 0.0:
                                nearest, at = distance, j
                            j = link[j]
            if turn == 0 and at < 0:
                cell = (place[i, 0] * shape[1] + place[i, 1]) * shape[2] + place[i, 2]
                link[i], head[cell] = head[cell], i
                number[i], chosen[found] = found, i
                found += 1
            elif turn == 1:
                owner[i] = number[i] if number[i] >= 0 else number[at]
    return owner, chosen[:found]


def _interpolation_weights(centres: np.ndarray, normals: np.ndarray, raw: RawScan) -> tuple[np.ndarray, np.ndarray]:
    """Find the samples nearest to each raw point, on its own side where that is known, and their weights."""
    targets, sources = centres, raw.points
    if not raw.is_cloud or (raw.normals is not None and raw.is_oriented):
        at = raw.normals if raw.normals is not None else vertex_normals(raw.points, raw.faces)
        targets = np.hstack([targets, SAMPLE_MATCH_NORMAL_LENGTH * normals])
        sources = np.hstack([sources, SAMPLE_MATCH_NORMAL_LENGTH * at])
    distance, nearest = cKDTree(targets).query(sources, k=INTERPOLATION_SAMPLE_COUNT)
    weights = 1.0 / (distance**2 + 1e-8)  # (0.1 mm)^2: a point at a sample takes its value
    weights /= weights.sum(axis=1, keepdims=True)
    return nearest.astype(np.int32), weights.astype(np.float32)


def _border_distance(positions: np.ndarray, normals: np.ndarray, spacing: float) -> np.ndarray:
    """Compute each sample's distance [m] to the nearest one of the border, at most `MAX_SAMPLE_BORDER_DISTANCE`."""
    count = min(24, len(positions))
    distance, index = cKDTree(positions).query(positions, k=count, distance_upper_bound=3.0 * spacing)
    there = np.isfinite(distance)
    index = np.where(there, index, 0)
    arm = positions[index] - positions[:, None]
    there[:, 0] = False
    there &= np.einsum("nka,na->nk", normals[index], normals) > 0
    first = unit(np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)]))
    second = np.cross(normals, first)
    angle = np.arctan2(np.einsum("nka,na->nk", arm, second), np.einsum("nka,na->nk", arm, first))
    # Where a neighbour is missing the largest angle stands in: it adds no gap.
    largest = np.where(there, angle, -np.pi).max(axis=1, keepdims=True)
    angle = np.sort(np.where(there, angle, largest), axis=1)
    gap = np.diff(angle, axis=1, append=angle[:, :1] + 2 * np.pi).max(axis=1)
    is_border = (gap > BORDER_GAP_ANGLE) | (there.sum(axis=1) < 3)
    if not is_border.any():
        return np.full(len(positions), MAX_SAMPLE_BORDER_DISTANCE)
    found: np.ndarray = np.minimum(cKDTree(positions[is_border]).query(positions)[0], MAX_SAMPLE_BORDER_DISTANCE)
    return found
