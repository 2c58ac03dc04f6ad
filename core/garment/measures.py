"""Body measures that base patterns are drafted from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BodyMeasures:
    """Describe the measures that the drafts need. The defaults are those of the built-in female body of 1.70 m,
    standing in T-pose with her feet at y = 0.

    Attributes:
        bust, waist, hip: Girths [m].
        nape_height: Height of the side neck point, where neck and shoulder meet [m].
        armpit_height, waist_height, hip_height, crotch_height: Heights above the feet [m].
        shoulder_half_width: From the middle to the shoulder's bone end [m].
        neck_half_width: From the middle to the side neck point [m].
    """

    bust: float = 0.92
    waist: float = 0.72
    hip: float = 1.00
    nape_height: float = 1.435
    armpit_height: float = 1.29
    waist_height: float = 1.07
    hip_height: float = 0.82
    crotch_height: float = 0.79
    shoulder_half_width: float = 0.18
    neck_half_width: float = 0.07
