"""Draft a shipped template to the wearer's own measures: worn in its size before anything is simulated."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...body import BELOW_ARMPIT, Body, Tape, armpit_height, crotch_height, rest_body
from ...garment import BodyMeasures, Pattern, draft_template

STEP = 0.01
"""Distance of the heights at which girths are taken [m]: the spacing of the body's vertices."""

WAIST_SPAN = 7
"""Cuts over which the trunk's girth is averaged before its narrowest place is looked for: the width of a waistband."""

BONE_END = 0.018
"""How far the shoulder's bone end lies outside its joint [m]; on the body of the drafts 18.0 against 16.2 cm."""

NECK_ABOVE = 0.03
"""How far above the neck's joint its width is taken [m], above the slope of the shoulders."""

NECK_POINT = 1.36
"""Half distance of the side neck points over the neck's half width; on the body of the drafts 7 cm."""

OUTGROWN = 1.12
"""Bust or hips over those of the library's drafts beyond which none of these goes over a wearer: a T-shirt of the
library is 1.02 m round the chest. A tank top that was hung on a man of 1.20 m slid down his arms."""


def measure_wearer(body: Body) -> BodyMeasures:
    """Take the measures that the drafts need from a body, in its T-pose.

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
    seat = np.arange(crotch, rest.joint("pelvis")[1], STEP)
    trunk = np.arange(rest.joint("pelvis")[1], armpit - BELOW_ARMPIT, STEP)
    tape = Tape(rest)
    around_seat = np.array([tape.trunk(height).value for height in seat])
    around_trunk = uniform_filter1d([tape.trunk(height).value for height in trunk], WAIST_SPAN, mode="nearest")
    throat = np.abs(heights - neck[1] - NECK_ABOVE) < STEP
    return BodyMeasures(
        bust=tape.trunk(armpit - BELOW_ARMPIT).value,
        waist=float(around_trunk.min()),
        hip=float(around_seat.max()),
        nape_height=float(neck[1]),
        armpit_height=armpit,
        waist_height=float(trunk[around_trunk.argmin()]),
        hip_height=float(seat[around_seat.argmax()]),
        crotch_height=crotch,
        shoulder_half_width=float(half + BONE_END),
        neck_half_width=NECK_POINT * float(off[throat].max()),
    )


def outgrown_measures(body: Body) -> BodyMeasures | None:
    """Return the measures to which a base pattern is drafted for a wearer whom the library's size does not go over.

    None for all others: the library's size is graded to the scan like any other, and what is known of it is kept.
    """
    measures, usual = measure_wearer(body), BodyMeasures()
    is_larger = measures.bust > OUTGROWN * usual.bust or measures.hip > OUTGROWN * usual.hip
    return measures if is_larger else None


def size_template(name: str, body: Body) -> Pattern:
    """Draft a shipped template anew from the measures of a body.

    Raises:
        TemplateUnknown: where there is none of that name.
    """
    return draft_template(name, measure_wearer(body))
