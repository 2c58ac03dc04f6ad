"""How a wearer's measures grow from size to size, where a table of sizes does not say it.

The ratios are the steps of W. Aldrich's standard body measurements (Metric Pattern Cutting for Women's Wear, 5th
edition, women of medium height, sizes 6 to 20), in which bust, waist and hips grow by 4 cm from size to size.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

NECK_GROWTH_RATIO = 1.0 / 4.0
"""Ratio of the growth of the neck's girth to that of the bust: 1 cm for 4 cm."""

SHOULDER_GROWTH_RATIO = 1.0 / 16.0
"""Ratio of the growth of the length of a shoulder to that of the bust: 2.5 mm for 4 cm."""

UPPER_ARM_GROWTH_RATIO = 3.0 / 10.0
"""Ratio of the growth of the upper arm's girth to that of the bust: 12 mm for 4 cm."""

WRIST_GROWTH_RATIO = 1.0 / 8.0
"""Ratio of the growth of the wrist's girth to that of the bust: 5 mm for 4 cm."""

ARMHOLE_DEPTH_GROWTH_RATIO = 1.0 / 10.0
"""Ratio of the growth of the armhole's depth to that of the bust: 4 mm for 4 cm."""

ARM_LENGTH_GROWTH_RATIO = 1.0 / 8.0
"""Ratio of the growth of the arm's length to that of the bust: 5 mm for 4 cm."""

BACK_LENGTH_GROWTH_RATIO = 1.0 / 10.0
"""Ratio of the growth of the length from nape to waist to that of the bust: 4 mm for 4 cm."""

HIP_DEPTH_GROWTH_RATIO = 3.0 / 40.0
"""Ratio of the growth of the length from waist to hips to that of the hips: 3 mm for 4 cm."""

KNEE_DEPTH_GROWTH_RATIO = 1.0 / 8.0
"""Ratio of the growth of the length from waist to knee to that of the hips: 5 mm for 4 cm."""

RISE_GROWTH_RATIO = 7.0 / 40.0
"""Ratio of the growth of the body rise to that of the hips: 7 mm for 4 cm."""

LEG_GROWTH_RATIO = 1.0 / 4.0
"""Ratio of the growth of a trouser leg's girth at knee and hem to that of the hips: 1 cm for 4 cm, as the trouser
bottom width of the same table."""

SAME_MEASURE_TOLERANCE = 1e-9
"""Largest difference of measures that are equal up to rounding [m]; of the stature, relative."""


@dataclass(frozen=True)
class Growth:
    """Describe by how much the measures of a size's wearer exceed those of the wearer of the pattern that is graded.

    Attributes:
        bust, waist, hip, neck, upper_arm, wrist, leg: Girths [m].
        shoulder: Length of one shoulder [m].
        armhole_depth, arm_length, back_length, hip_depth, knee_depth, rise: Lengths, beside what the stature changes
            [m].
        stature: Height relative to the wearer's [1].
    """

    bust: float = 0.0
    waist: float = 0.0
    hip: float = 0.0
    neck: float = 0.0
    shoulder: float = 0.0
    upper_arm: float = 0.0
    wrist: float = 0.0
    leg: float = 0.0
    armhole_depth: float = 0.0
    arm_length: float = 0.0
    back_length: float = 0.0
    hip_depth: float = 0.0
    knee_depth: float = 0.0
    rise: float = 0.0
    stature: float = 1.0

    @classmethod
    def follow(
        cls, bust: float, waist: float, hip: float, stature: float = 1.0, known: Mapping[str, float] | None = None
    ) -> Growth:
        """Return the growth of all measures with the girths of the trunk.

        Args:
            bust, waist, hip: Growth of these girths [m].
            stature: Height relative to the wearer's [1].
            known: Growth of other measures that a table has, by their names [m].
        """
        usual = {
            "neck": NECK_GROWTH_RATIO * bust,
            "shoulder": SHOULDER_GROWTH_RATIO * bust,
            "upper_arm": UPPER_ARM_GROWTH_RATIO * bust,
            "wrist": WRIST_GROWTH_RATIO * bust,
            "leg": LEG_GROWTH_RATIO * hip,
            "armhole_depth": ARMHOLE_DEPTH_GROWTH_RATIO * bust,
            "arm_length": ARM_LENGTH_GROWTH_RATIO * bust,
            "back_length": BACK_LENGTH_GROWTH_RATIO * bust,
            "hip_depth": HIP_DEPTH_GROWTH_RATIO * hip,
            "knee_depth": KNEE_DEPTH_GROWTH_RATIO * hip,
            "rise": RISE_GROWTH_RATIO * hip,
        }
        return cls(bust=bust, waist=waist, hip=hip, stature=stature, **(usual | dict(known or {})))

    @property
    def is_zero(self) -> bool:
        """Check whether nothing grows, beside the rounding of a table."""
        return all(abs(getattr(self, field.name) - field.default) < SAME_MEASURE_TOLERANCE for field in fields(self))
