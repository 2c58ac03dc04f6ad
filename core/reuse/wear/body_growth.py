"""Measure by how much one body exceeds another, in the measures that grade rules of named points take."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...body.girths import TapeMeasure
from ...body.skinning import rest_body
from ...garment.sizes.figures import NECK_SHARE
from ...garment.sizes.growth import Growth
from ...recover.drape.sizing import measure_wearer


def measure_growth(old: Body, new: Body) -> Growth:
    """Return the growth from one body to another, each in its T-pose: girths and lengths, those of the second less
    those of the first times the ratio of both statures.

    The neck's girth follows the half width that drafts take; wrist, knees and legs follow bust and hips.

    Args:
        old: The body that a pattern was made for.
        new: The other one.
    """
    one, other = measure_wearer(old), measure_wearer(new)
    tall = measure_stature(new) / measure_stature(old)

    def grow(upper: str, lower: str) -> float:
        before, after = (getattr(each, upper) - getattr(each, lower) for each in (one, other))
        return float(after - tall * before)

    arms = [TapeMeasure.of(each).measure("upper_arm").value for each in (old, new)]
    reach = [_measure_arm(each) for each in (old, new)]
    neck = other.neck_half_width - one.neck_half_width
    known = {
        "neck": neck / NECK_SHARE,
        "shoulder": other.shoulder_half_width - one.shoulder_half_width - neck,
        "upper_arm": arms[1] - arms[0],
        "arm_length": reach[1] - tall * reach[0],
        "armhole_depth": grow("nape_height", "armpit_height"),
        "back_length": grow("nape_height", "waist_height"),
        "hip_depth": grow("waist_height", "hip_height"),
        "rise": grow("waist_height", "crotch_height"),
    }
    return Growth.follow(other.bust - one.bust, other.waist - one.waist, other.hip - one.hip, tall, known)


def measure_stature(body: Body) -> float:
    """Return the height of a body in its T-pose [m]."""
    return float(np.ptp(rest_body(body).vertices[:, 1]))


def _measure_arm(body: Body) -> float:
    """Return the distance from the left shoulder to the wrist of a body in its T-pose [m]."""
    rest = rest_body(body)
    return float(np.linalg.norm(rest.joint("left_wrist") - rest.joint("left_shoulder")))
