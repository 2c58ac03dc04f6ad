"""Curves of any dimension, closed or open: length, points at equal arc length, closest points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class CurvePoints:
    """Describe points (1 - t) x_i + t x_(i+1) of a curve: `segment` i from corner i to the next, `along` t from 0 to 1,
    shape [n] each, and the points `foot` [m], shape [n, d]."""

    segment: np.ndarray
    along: np.ndarray
    foot: np.ndarray


@dataclass(frozen=True)
class Curve:
    """Describe a polygon by its corners in order [m], shape [corner_count, d].

    Attributes:
        points: The corners; the first is not repeated.
        is_closed: Whether a segment joins the last corner to the first.
    """

    points: np.ndarray
    is_closed: bool = True

    @cached_property
    def lengths(self) -> np.ndarray:
        """Return the length of each segment [m], shape [segment_count]."""
        return np.asarray(np.linalg.norm(self.ends - self.starts, axis=1))

    @cached_property
    def length(self) -> float:
        """Return the length of the whole curve [m]."""
        return float(self.lengths.sum())

    @cached_property
    def arc(self) -> np.ndarray:
        """Return the arc length up to each corner, and of a closed curve back to the first [m], from 0, shape
        [segment_count + 1]."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def starts(self) -> np.ndarray:
        """Return the corner at which each segment begins [m], shape [segment_count, d]."""
        return self.points if self.is_closed else self.points[:-1]

    @cached_property
    def ends(self) -> np.ndarray:
        """Return the corner at which each segment ends [m], shape [segment_count, d]."""
        return np.roll(self.points, -1, axis=0) if self.is_closed else self.points[1:]

    @cached_property
    def tangents(self) -> np.ndarray:
        """Return the unit vector along each segment, 0 for one without length, shape [segment_count, d]."""
        return np.asarray((self.ends - self.starts) / np.maximum(self.lengths, 1e-9)[:, None])

    @cached_property
    def corner_lengths(self) -> np.ndarray:
        """Return the length that each corner stands for, half of the segments beside it [m], shape [corner_count]."""
        if self.is_closed:
            return np.asarray(0.5 * (self.lengths + np.roll(self.lengths, 1)))
        return np.asarray(0.5 * (np.append(self.lengths, 0.0) + np.append(0.0, self.lengths)))

    def resample(self, count: int) -> np.ndarray:
        """Return `count` points at equal arc length, from the first corner, of an open curve to the last one [m], shape
        [count, d]."""
        return self._at(np.arange(count) * (self.arc[-1] / (count if self.is_closed else count - 1)), self.arc)

    def at_shares(self, share: np.ndarray) -> np.ndarray:
        """Return the points at shares of the arc length, of a closed curve modulo 1 [m]; a coordinate axis is
        appended."""
        return self._at(share % 1.0 if self.is_closed else share, self.arc / self.arc[-1])

    def locate(self, at: np.ndarray) -> CurvePoints:
        """Find the segments and the points at arc lengths from 0 to `length` [m], shape [n]."""
        segment = np.minimum(np.searchsorted(self.arc[1:], at), len(self.lengths) - 1)
        along = 1 - (self.arc[segment + 1] - at) / np.maximum(self.lengths[segment], 1e-12)
        return self._points(segment, np.clip(along, 0.0, 1.0))

    def closest(self, points: np.ndarray) -> CurvePoints:
        """Find the closest point of the curve to each point [m], shape [n, d]; exact."""
        from .segments import closest_segments

        start, end = (np.ascontiguousarray(corners, dtype=np.float64) for corners in (self.starts, self.ends))
        return self._points(*closest_segments(np.ascontiguousarray(points, dtype=np.float64), start, end))

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Compute the distances of points from the curve [m], shape [n]."""
        return np.asarray(np.linalg.norm(points - self.closest(points).foot, axis=1))

    def _points(self, segment: np.ndarray, along: np.ndarray) -> CurvePoints:
        foot = self.starts[segment] * (1 - along)[:, None] + self.ends[segment] * along[:, None]
        return CurvePoints(segment, along, foot)

    def _at(self, queries: np.ndarray, known: np.ndarray) -> np.ndarray:
        line = np.concatenate([self.points, self.points[:1]]) if self.is_closed else self.points
        return interpolate_polyline(queries, known, line)


def polyline_length(line: np.ndarray) -> float:
    """Compute the length of an open polyline [m], shape [n, d]."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def resample_polyline(line: np.ndarray, count: int) -> np.ndarray:
    """Return `count` points at equal arc length along an open polyline, both ends included [m], shape [count, d]."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    return interpolate_polyline(np.linspace(0.0, arc[-1], count), arc, line)


def interpolate_polyline(queries: np.ndarray, known: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Interpolate corners, shape [n, d], given at ascending parameters `known`, linearly at `queries`."""
    return np.stack([np.interp(queries, known, line[:, k]) for k in range(line.shape[1])], axis=-1)
