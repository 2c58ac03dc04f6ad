"""Draft a shipped template to the wearer's own measures before it is simulated."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...body.body import Body
from ...body.girths import BELOW_ARMPIT, TapeMeasure, armpit_height, crotch_height
from ...body.skinning import rest_body
from ...garment.measures import BodyMeasures

GIRTH_HEIGHT_STEP = 0.01
"""Distance of the heights at which girths are taken [m]: the spacing of the body's vertices."""

WAIST_AVERAGING_COUNT = 7
"""Number of cuts over which the trunk's girth is averaged to find the narrowest place: the width of a waistband."""

SHOULDER_BONE_OFFSET = 0.018
"""Distance of the end of the shoulder bone outside of its joint [m]; on the body of the drafts 18.0 against 16.2 cm."""

NECK_WIDTH_HEIGHT = 0.03
"""Height above the joint of the neck at which its width is taken [m], above the slope of the shoulders."""

NECK_POINT_RATIO = 1.36
"""Ratio of half the distance of the side neck points to half the width of the neck; on the body of the drafts 7 cm."""

MAX_LIBRARY_SIZE_RATIO = 1.12
"""Ratio of bust or hips of a wearer to those of the library's drafts, above which no draft fits over the wearer: a
T-shirt of the library is 1.02 m round the chest. A tank top on a man of 1.20 m slid down his arms."""


def measure_wearer(body: Body) -> BodyMeasures:
    """Measure a body in its T-pose for the drafts.

    Girths are those of a tape: of the convex hull of a level cut. The hips are the widest place from the crotch to the
    pelvis, the waist the narrowest from there to the armpit.
    """
    rest = rest_body(body)
    centre, shoulder, neck = rest.joint("pelvis")[0], rest.joint("left_shoulder"), rest.joint("neck")
    off = np.abs(rest.vertices[:, 0] - centre)
    heights = rest.vertices[:, 1]
    half = abs(shoulder[0] - centre)
    crotch = crotch_height(rest)
    armpit = armpit_height(rest)
    seat = np.arange(crotch, rest.joint("pelvis")[1], GIRTH_HEIGHT_STEP)
    trunk = np.arange(rest.joint("pelvis")[1], armpit - BELOW_ARMPIT, GIRTH_HEIGHT_STEP)
    tape = TapeMeasure(rest)
    around_seat = np.array([tape.trunk(height).value for height in seat])
    around_trunk = uniform_filter1d(
        [tape.trunk(height).value for height in trunk], WAIST_AVERAGING_COUNT, mode="nearest"
    )
    throat = np.abs(heights - neck[1] - NECK_WIDTH_HEIGHT) < GIRTH_HEIGHT_STEP
    return BodyMeasures(
        bust=tape.trunk(armpit - BELOW_ARMPIT).value,
        waist=float(around_trunk.min()),
        hip=float(around_seat.max()),
        nape_height=float(neck[1]),
        armpit_height=armpit,
        waist_height=float(trunk[around_trunk.argmin()]),
        hip_height=float(seat[around_seat.argmax()]),
        crotch_height=crotch,
        shoulder_half_width=float(half + SHOULDER_BONE_OFFSET),
        neck_half_width=NECK_POINT_RATIO * float(off[throat].max()),
    )


def oversize_measures(body: Body) -> BodyMeasures | None:
    """Return the measures of a wearer too large for the library's size; None for others, who keep that size."""
    measures, usual = measure_wearer(body), BodyMeasures()
    is_larger = measures.bust > MAX_LIBRARY_SIZE_RATIO * usual.bust or measures.hip > MAX_LIBRARY_SIZE_RATIO * usual.hip
    return measures if is_larger else None
