"""Transform results of a raw scan into the frame of its truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.geometry.rigid import fit_rigid
from ...core.scan.raw import RawScan


@dataclass(frozen=True)
class TruthFrame:
    """Describe the rigid transform from the coordinates of a `RawScan` to those of the truth, both in metres.

    Attributes:
        rotation: R, shape [3, 3].
        shift: t [m], shape [3].
        error: RMS distance of the transformed points from the truth [m]: what the reader changed.
    """

    rotation: np.ndarray
    shift: np.ndarray
    error: float

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Transform positions [m], shape [n, 3]."""
        return np.asarray(points @ self.rotation.T + self.shift)


def find_frame(raw: RawScan, true_points: np.ndarray) -> TruthFrame:
    """Fit the rigid transform between a scan as it was read and its truth, from the points themselves.

    Args:
        raw: The scan as it was read.
        true_points: Each point of the file in the truth's frame [m], shape [file_count, 3].
    """
    kept = np.flatnonzero(raw.place >= 0)
    points, truth = raw.points[raw.place[kept]], true_points[kept]
    motion = fit_rigid(points, truth)
    frame = TruthFrame(motion.rotation, motion.translation, 0.0)
    error = np.sqrt(np.mean(np.sum((frame.apply(points) - truth) ** 2, axis=1)))
    return TruthFrame(frame.rotation, frame.shift, float(error))
