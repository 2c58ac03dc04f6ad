"""Spread a wearer's limbs in a motion to make room for the garment, and report the changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...body.motion.clear_limbs import LIMB_GROUPS, MAX_LIMB_SPREAD_ANGLE, clear_limbs
from ...body.motion.track import Track
from ...geometry.surface import TriangleSurface
from ..wear.worn import WornGarment
from .settings import AnimateSettings

COVERED_SKIN_RADIUS = 0.02
"""Distance along the skin from the foot of a node within which it is covered [m]: an edge of cloth of 4000 vertices."""

MIN_REPORTED_SPREAD_ANGLE = np.deg2rad(0.5)
"""Smallest angle of a spread limb that is reported [rad]; smaller ones are not visible."""


@dataclass(frozen=True)
class LimbSpread:
    """Describe how limbs were spread, by limb of `LIMB_GROUPS`: largest angle [degrees], first and last time of the
    motion at which it is spread [s] or None, and whether more than the limit would have been needed."""

    degrees: dict[str, float]
    spans: dict[str, tuple[float, float] | None]
    missed: dict[str, bool]

    def warnings(self) -> tuple[str, ...]:
        """Return a sentence for each limb that was spread."""
        texts = []
        for name, degrees in self.degrees.items():
            span = self.spans[name]
            if span is None:
                continue
            each = " each" if name == "legs" else ""
            text = (
                f"{name}: spread by up to {degrees:.1f} degrees{each} from {span[0]:.2f} to {span[1]:.2f} s of the "
                "motion, for room between the parts of the body; --keep-motion leaves it."
            )
            if self.missed[name]:
                text += f" {np.rad2deg(MAX_LIMB_SPREAD_ANGLE):.0f} degrees are the most, and were not enough."
            texts.append(text)
        return tuple(texts)


def find_covered_vertices(worn: WornGarment) -> np.ndarray:
    """Find the wearer's vertices that are covered by cloth, bool, shape [vertex_count]."""
    feet = TriangleSurface(worn.body.vertices, worn.body.faces).closest(worn.garment.nodes).foot
    return np.asarray(
        cKDTree(feet).query(worn.body.vertices, distance_upper_bound=COVERED_SKIN_RADIUS)[0] < COVERED_SKIN_RADIUS
    )


def make_room_for_garment(worn: WornGarment, track: Track, settings: AnimateSettings) -> tuple[Track, LimbSpread]:
    """Return a motion with room for a garment between its wearer's limbs, and the changes; see `clear_limbs`."""
    end = settings.end if settings.end is not None else track.seconds
    cleared = clear_limbs(track, worn.body, find_covered_vertices(worn), settings.begin, end)
    degrees, spans, missed = {}, {}, {}
    for column, name in enumerate(LIMB_GROUPS):
        angles = cleared.angles[:, column]
        degrees[name] = float(np.rad2deg(angles.max()))
        spread = np.flatnonzero(angles > MIN_REPORTED_SPREAD_ANGLE)
        spans[name] = (float(spread[0] / track.rate), float(spread[-1] / track.rate)) if len(spread) else None
        missed[name] = bool(cleared.missed[:, column].any())
    return cleared.track, LimbSpread(degrees, spans, missed)
