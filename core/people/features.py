"""Compute features of every sample of a person that depend neither on place and heading nor on colour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .limbs import FOLDED_BODY_PARTS, BodyPlace, Limb, place_on_body
from .neighbourhood import NEIGHBOURHOOD_RADII, neighbourhood_statistics
from .points import FittedPerson, PersonPoints

FEATURE_LAYOUT_VERSION = 1
"""Version of the features' layout; weights that were trained on another one are refused."""

OFFSET_RANGE = (-0.06, 0.30)
"""Range to which offsets from the body are clamped [m]: it includes the fit's errors and a wide skirt."""
STATION_BIN = 0.01
"""Height of the slices of a limb over which offsets are collected [m]: three samples across."""
SLICE_REACH = 2
"""Number of slices on either side that a slice's quantiles include: 5 cm in all, some hundred samples of an arm."""
SLICE_SHARES = (0.2, 0.5, 0.8)
"""Quantiles of a slice's offsets: its skin, if it has some, its middle, its folds."""
SLICE_STEP = 4
"""Number of slices between the two places whose difference is a slice's step: 4 cm."""

FEATURE_NAMES: tuple[str, ...] = (
    "offset", "distance", "normal_agreement",
    "normal_along", "normal_front", "normal_side", "gap_along", "gap_front", "gap_side",
    "rest_aside", "rest_up", "rest_forward", "station", "around_front", "around_side",
    *(f"part_{name}" for name in FOLDED_BODY_PARTS),
    *(f"{value}_{1000 * radius:.0f}" for radius in NEIGHBOURHOOD_RADII
      for value in ("offset_mean", "offset_spread", "offset_step", "curvature", "normal_spread", "crowding")),
    "border", "height_over_floor", "height_share",
    *(f"slice_{100 * share:.0f}" for share in SLICE_SHARES), "slice_excess", "slice_step", "slice_both",
    *(f"typical_{name}" for name in FOLDED_BODY_PARTS),
)  # fmt: skip
"""Names of the columns; lengths in `FEATURE_LENGTH_SCALE`, directions folded so that left and right are alike."""

FEATURE_LENGTH_SCALE = 0.02
"""Length by which offsets and steps are divided [m]: the scale of ease."""


@dataclass(frozen=True)
class Features:
    """Describe a person's samples by features.

    Attributes:
        values: One row for each sample, float32, shape [n, F].
        names: Names of the columns, `FEATURE_NAMES`.
        place: Where on the body each sample is.
        version: `FEATURE_LAYOUT_VERSION`.
    """

    values: np.ndarray
    names: tuple[str, ...]
    place: BodyPlace
    version: int = FEATURE_LAYOUT_VERSION

    def column(self, name: str) -> np.ndarray:
        """Return one feature of all samples by its name, shape [n]."""
        return np.asarray(self.values[:, self.names.index(name)])


def describe_points(points: PersonPoints, fit: FittedPerson) -> Features:
    """Compute the features of a person's samples from the fitted body and from their neighbours.

    All is relative to the body: a mirrored person has the same features at the mirrored places.

    Args:
        points: The samples.
        fit: The body fitted to them.
    """
    body = fit.body
    place = place_on_body(points, body)
    offset = np.clip(place.offset, *OFFSET_RANGE)
    side = np.cross(place.along, place.front) * _handedness(place)[:, None]
    frame = np.stack([place.along, place.front, side], axis=1)
    height = float(np.ptp(body.rest_vertices[:, 1]))
    floor = float(body.vertices[:, 1].min())
    local = neighbourhood_statistics(points.positions, points.normals, offset, place.along)
    columns = [
        offset[:, None] / FEATURE_LENGTH_SCALE,
        np.minimum(place.distance, OFFSET_RANGE[1])[:, None] / FEATURE_LENGTH_SCALE,
        np.einsum("na,na->n", points.normals, place.normal)[:, None],
        np.einsum("nka,na->nk", frame, points.normals),
        np.clip(np.einsum("nka,na->nk", frame, points.positions - place.foot), -0.3, 0.3) / FEATURE_LENGTH_SCALE,
        np.abs(place.rest[:, :1]) / height,
        place.rest[:, 1:] / height,
        place.station[:, None] / height,
        np.einsum("nka,na->nk", frame[:, 1:], place.normal),
        place.parts,
        *(_scale_statistics(values) for values in local),
        points.border[:, None] / FEATURE_LENGTH_SCALE,
        (points.positions[:, 1:2] - floor) / FEATURE_LENGTH_SCALE / 10,
        (points.positions[:, 1:2] - floor) / height,
        _slice_features(place, offset) / FEATURE_LENGTH_SCALE,
        np.broadcast_to(_typical_offsets(place, offset) / FEATURE_LENGTH_SCALE, place.parts.shape),
    ]
    values = np.hstack(columns).astype(np.float32)
    return Features(values=values, names=FEATURE_NAMES, place=place)


def _handedness(place: BodyPlace) -> np.ndarray:
    """Return the sign that makes "to the side" the same on a mirrored person: towards the middle, of arms downwards."""
    sign = np.where(place.rest[:, 0] < 0, -1.0, 1.0)
    # Down x forward is -x, inwards on the left; up x forward (neck and head) is +x; left arm x forward is down.
    return np.where(place.limb == Limb.NECK, -sign, sign)


def _scale_statistics(local: np.ndarray) -> np.ndarray:
    """Scale the neighbourhood's statistics to about 1, columns as `neighbourhood_statistics` returns them."""
    out = local.copy()
    out[:, :3] /= FEATURE_LENGTH_SCALE
    out[:, 3] = np.clip(out[:, 3] * FEATURE_LENGTH_SCALE, -3.0, 3.0)
    return out


def _slice_features(place: BodyPlace, offset: np.ndarray) -> np.ndarray:
    """Compute features of the slice of the limb around each sample [m], shape [n, 6].

    Quantiles of its offsets; the sample's less the median; the median 2 cm further out less that 2 cm further in; and
    the median of both limbs of a pair.
    """
    out = np.zeros((len(offset), len(SLICE_SHARES) + 3))
    tables = {limb: _slice_table(place, offset, (limb,)) for limb in Limb}
    half = SLICE_STEP // 2
    pairs = ((Limb.LEFT_ARM, Limb.RIGHT_ARM), (Limb.LEFT_LEG, Limb.RIGHT_LEG), (Limb.TRUNK,), (Limb.NECK,))
    for pair in pairs:
        both = _slice_table(place, offset, pair)
        for limb in pair:
            rows = np.flatnonzero(place.limb == limb)
            if not len(rows):
                continue
            first, table = tables[limb]
            row = np.floor(place.station[rows] / STATION_BIN).astype(np.int64)
            middle, last = table[:, 1], len(table) - 1
            out[rows, : len(SLICE_SHARES)] = table[row - first]
            out[rows, -3] = offset[rows] - out[rows, 1]
            out[rows, -2] = middle[np.clip(row - first + half, 0, last)] - middle[np.clip(row - first - half, 0, last)]
            out[rows, -1] = both[1][row - both[0], 1]
    return out


def _typical_offsets(place: BodyPlace, offset: np.ndarray) -> np.ndarray:
    """Compute the median offset of each part of the body [m], shape [11]; 0 where a part was not seen.

    It is the same for all samples: whether the shins are bare shows what hangs on the hips.
    """
    members = place.parts > 0.5
    return np.array([np.median(offset[column]) if column.any() else 0.0 for column in members.T])


def _slice_table(place: BodyPlace, offset: np.ndarray, limbs: tuple[Limb, ...]) -> tuple[int, np.ndarray]:
    """Return the number of the first slice of limbs, and a row of quantiles of offsets for each slice."""
    rows = np.flatnonzero(np.isin(place.limb, limbs))
    if not len(rows):
        return 0, np.zeros((1, len(SLICE_SHARES)))
    row = np.floor(place.station[rows] / STATION_BIN).astype(np.int64)
    order = np.argsort(row, kind="stable")
    row, sorted_offset = row[order], offset[rows][order]
    first = int(row[0])
    centre = np.arange(first, int(row[-1]) + 1)
    begin, end = np.searchsorted(row, centre - SLICE_REACH), np.searchsorted(row, centre + SLICE_REACH + 1)
    table = np.zeros((len(centre), len(SLICE_SHARES)))
    for i, (a, b) in enumerate(zip(begin, end, strict=True)):
        table[i] = np.quantile(sorted_offset[a:b], SLICE_SHARES) if b > a else (table[i - 1] if i else 0.0)
    return first, table
