"""Measure the estimated wearer and the garments recovered from a raw scan against the true ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.geometry.surface import TriangleSurface
from ...core.judge.fit import SURFACE_SAMPLES
from ...core.people.part import GARMENTS, Part


@dataclass(frozen=True)
class BodyScore:
    """Describe the distance from the true body to the estimated one over some part of its surface.

    Attributes:
        mean: Area-weighted mean [m].
        p95: Area-weighted 95th percentile [m].
    """

    mean: float
    p95: float


@dataclass(frozen=True)
class VisibleScore:
    """Describe the distances between a detail mesh and the visible part of the true garment.

    Attributes:
        s2t: RMS distance from the detail mesh to the truth [m], where the nearest point of the truth is visible.
        t2s: RMS distance from the truth's visible surface to the detail mesh [m].
        s2t_p95: 95th percentile of the former [m].
        t2s_p95: 95th percentile of the latter [m].
    """

    s2t: float
    t2s: float
    s2t_p95: float
    t2s_p95: float


def measure_true_body(
    truth: tuple[np.ndarray, np.ndarray], cover: np.ndarray, body: tuple[np.ndarray, np.ndarray]
) -> dict[str, BodyScore]:
    """Measure from the vertices of the true body to the surface of ours, each weighted by its share of area.

    Args:
        truth: The true body's positions [m], shape [n, 3], and faces.
        cover: `Part` that covers each of its vertices, 0 where it is bare, shape [n].
        body: Our body's positions [m] in the same frame, and faces.

    Returns:
        Scores of `all`, `covered` (below garments), `bare` and `hidden` (below hair or shoes), those that exist.
    """
    surface = TriangleSurface(*truth)
    distance = TriangleSurface(*body).distance(surface.vertices)
    masks = {
        "all": np.ones(len(cover), bool),
        "covered": np.isin(cover, [int(part) for part in GARMENTS]),
        "bare": cover == Part.SKIN,
        "hidden": np.isin(cover, [int(Part.HAIR), int(Part.SHOES)]),
    }
    areas = surface.vertex_areas
    return {name: _score_by_area(distance[mask], areas[mask]) for name, mask in masks.items() if mask.any()}


def _score_by_area(distance: np.ndarray, area: np.ndarray) -> BodyScore:
    order = np.argsort(distance)
    share = np.cumsum(area[order]) / area.sum()
    at = min(int(np.searchsorted(share, 0.95)), len(order) - 1)
    return BodyScore(float(np.average(distance, weights=area)), float(distance[order][at]))


def measure_visible(
    detail: tuple[np.ndarray, np.ndarray],
    truth: tuple[np.ndarray, np.ndarray],
    visible: np.ndarray,
    seed: int = 0,
    samples: int = SURFACE_SAMPLES,
) -> VisibleScore:
    """Measure a detail mesh against a true garment that the scan shows only in part.

    A face of the truth counts as visible if its three corners are. What the recovery makes of hidden cloth is left out
    in both directions.

    Args:
        detail: Our mesh's positions [m] and faces, in the truth's frame.
        truth: Positions [m] and faces of the true garment.
        visible: True at the truth's vertices that the scan shows, shape [n].
        seed: Seed of the samples.
        samples: Number of samples on each surface.
    """
    rng = np.random.default_rng(seed)
    surface, true = TriangleSurface(*detail), TriangleSurface(*truth)
    shown = np.asarray(visible[true.faces].all(axis=1))
    if not shown.any():
        return VisibleScore(np.inf, np.inf, np.inf, np.inf)
    closest = true.closest(surface.sample(samples, rng)[0])
    forward = closest.distance[shown[closest.face]]
    forward = forward if len(forward) else closest.distance
    seen = TriangleSurface(true.vertices, true.faces[shown])
    backward = surface.distance(seen.sample(samples, rng)[0])
    return VisibleScore(
        s2t=float(np.sqrt(np.mean(forward**2))),
        t2s=float(np.sqrt(np.mean(backward**2))),
        s2t_p95=float(np.quantile(forward, 0.95)),
        t2s_p95=float(np.quantile(backward, 0.95)),
    )
