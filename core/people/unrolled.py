"""Unroll a limb to a grid of station by angle, on which rings are searched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body.body import JOINTS, Body
from .limbs import BodyPlace, Limb

STATION_STEP = 0.008
"""Height of a cell along the limb [m]: about one sample."""
LIMB_COLUMN_COUNT = 48
"""Number of cells around a limb: 6 mm apart on a wrist, 2 cm on a trunk."""

NECK_RADIUS = 0.06
"""Horizontal distance [m] from the neck's axis that counts as station 0 at the height of the neck joint."""
FILL_ITERATIONS = 12
"""Number of iterations in which values spread by a cell into cells without samples: fills holes of up to 20 cm."""


@dataclass(frozen=True)
class Chart:
    """Describe where samples are on one unrolled limb.

    Attributes:
        limb: Which one.
        members: The samples on it, shape [m].
        station: Their length along it [m], away from the body's middle, shape [m].
        angle: Their angle around it [rad], 0 in front; the left and the right limb's angles turn against each other, so
            that a mirrored person has the same charts.
    """

    limb: Limb
    members: np.ndarray
    station: np.ndarray
    angle: np.ndarray


@dataclass(frozen=True)
class UnrolledGrid:
    """Describe a chart divided into cells.

    Attributes:
        chart: The chart.
        first: Station of the first row's middle [m].
        row: Row of each member, shape [m].
        column: Column of each member, shape [m].
        counts: Number of samples in each cell, shape [rows, LIMB_COLUMN_COUNT].
    """

    chart: Chart
    first: float
    row: np.ndarray
    column: np.ndarray
    counts: np.ndarray

    @property
    def stations(self) -> np.ndarray:
        """Return the station of each row's middle [m], shape [rows]."""
        return np.asarray(self.first + STATION_STEP * np.arange(len(self.counts)))

    @property
    def is_near(self) -> np.ndarray:
        """Mark cells with samples in them or beside them, shape [rows, LIMB_COLUMN_COUNT]; others are unknown."""
        return np.asarray(_sum_around(_sum_around(self.counts)) + self.counts > 0)

    def without(self, hidden: np.ndarray) -> UnrolledGrid:
        """Return the grid of the same cells without some samples, bool of shape [n]."""
        kept = ~hidden[self.chart.members]
        chart = Chart(self.chart.limb, self.chart.members[kept], self.chart.station[kept], self.chart.angle[kept])
        row, column = self.row[kept], self.column[kept]
        seen = np.bincount(row * LIMB_COLUMN_COUNT + column, minlength=self.counts.size).reshape(self.counts.shape)
        return UnrolledGrid(chart, self.first, row, column, seen)

    def at_samples(self, cells: np.ndarray, count: int, default: float) -> np.ndarray:
        """Return the cells' values, shape [rows, LIMB_COLUMN_COUNT], at all samples, shape [count], or the default."""
        out = np.full(count, default)
        out[self.chart.members] = cells[self.row, self.column]
        return out

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Return the mean of the samples' values, shape [n], in each cell, shape [rows, LIMB_COLUMN_COUNT].

        Cells without samples take the mean of their neighbours, iteration by iteration; those never reached are 0.
        """
        of_members = np.asarray(values, dtype=np.float64)[self.chart.members]
        flat = self.row * LIMB_COLUMN_COUNT + self.column
        total = np.bincount(flat, of_members, self.counts.size).reshape(self.counts.shape)
        count = self.counts.astype(np.float64)
        for _ in range(FILL_ITERATIONS):
            empty = count == 0
            if not empty.any():
                break
            total_around, count_around = (_sum_around(np.where(empty, 0.0, a)) for a in (total, count))
            total = np.where(empty, total_around, total)
            count = np.where(empty, count_around, count)
        return np.asarray(total / np.maximum(count, 1.0))


def _sum_around(values: np.ndarray) -> np.ndarray:
    """Sum the four neighbours of each cell; angles are periodic, stations are not."""
    out = np.roll(values, 1, axis=1) + np.roll(values, -1, axis=1)
    out[1:] += values[:-1]
    out[:-1] += values[1:]
    return np.asarray(out)


def unroll(place: BodyPlace, body: Body, limb: Limb) -> UnrolledGrid:
    """Unroll one limb.

    Arms begin 8 cm inside the shoulder joint, to include armholes; the trunk goes down to the feet, to include skirts;
    the neck's stations run down the neck and on over shoulders, chest and back.
    """
    chart = _chart(place, body, limb)
    if not len(chart.members):
        return UnrolledGrid(chart, 0.0, chart.members, chart.members, np.zeros((1, LIMB_COLUMN_COUNT), dtype=np.int64))
    return cut_chart(chart)


def cut_chart(chart: Chart) -> UnrolledGrid:
    """Divide a chart, which has members, into cells."""
    first = float(chart.station.min())
    row = np.floor((chart.station - first) / STATION_STEP).astype(np.int64)
    column = np.floor(chart.angle / (2 * np.pi) * LIMB_COLUMN_COUNT).astype(np.int64) % LIMB_COLUMN_COUNT
    rows = int(row.max()) + 1
    seen = np.bincount(row * LIMB_COLUMN_COUNT + column, minlength=rows * LIMB_COLUMN_COUNT).reshape(
        rows, LIMB_COLUMN_COUNT
    )
    return UnrolledGrid(chart, first + 0.5 * STATION_STEP, row, column, seen)


def _chart(place: BodyPlace, body: Body, limb: Limb) -> Chart:
    """Place the samples on a limb by their body points in the T-pose."""

    def joint(name: str) -> np.ndarray:
        return np.asarray(body.rest_joints[JOINTS.index(name)])

    def share(*names: str) -> np.ndarray:
        return np.asarray(place.weights[:, [JOINTS.index(name) for name in names]].sum(axis=1))

    rest = place.rest
    arms = share(*(name for name in JOINTS if any(part in name for part in ("shoulder", "elbow", "wrist", "hand"))))
    if limb in (Limb.LEFT_ARM, Limb.RIGHT_ARM):
        side, sign = ("left", 1.0) if limb == Limb.LEFT_ARM else ("right", -1.0)
        shoulder = joint(f"{side}_shoulder")
        arm = rest - shoulder
        station = sign * arm[:, 0]
        is_member = (station > -0.08) & (arm[:, 1] > -0.2) & (share("head", "neck") < 0.5)
        return _make_chart(limb, is_member, station, np.arctan2(arm[:, 1], arm[:, 2]))
    if limb in (Limb.LEFT_LEG, Limb.RIGHT_LEG):
        side, sign = ("left", 1.0) if limb == Limb.LEFT_LEG else ("right", -1.0)
        chain = np.stack([joint(f"{side}_{name}") for name in ("ankle", "knee", "hip")])
        axis = np.stack([np.interp(rest[:, 1], chain[:, 1], chain[:, a]) for a in (0, 2)], axis=1)
        is_member = share(*(f"{side}_{name}" for name in ("hip", "knee", "ankle", "foot"))) > 0.5
        angle = np.arctan2(sign * (rest[:, 0] - axis[:, 0]), rest[:, 2] - axis[:, 1])
        return _make_chart(limb, is_member, chain[2, 1] - rest[:, 1], angle)
    neck = joint("neck")
    if limb == Limb.NECK:
        radius = np.hypot(rest[:, 0], rest[:, 2] - neck[2])
        station = radius - NECK_RADIUS + neck[1] - rest[:, 1]
        is_member = (rest[:, 1] > joint("spine2")[1]) & (arms < 0.5) & (share("head") < 0.5)
        return _make_chart(limb, is_member, station, np.arctan2(rest[:, 0], rest[:, 2] - neck[2]))
    is_member = (arms < 0.5) & (share("head", "neck") < 0.5)
    return _make_chart(limb, is_member, neck[1] - rest[:, 1], np.arctan2(rest[:, 0], rest[:, 2] - joint("pelvis")[2]))


def _make_chart(limb: Limb, is_member: np.ndarray, station: np.ndarray, angle: np.ndarray) -> Chart:
    members = np.flatnonzero(is_member)
    return Chart(limb, members, station[members], np.mod(angle[members], 2 * np.pi))
