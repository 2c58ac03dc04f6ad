"""Settings of an animation."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...cloth.motion_step import StepSettings
from ...cloth.settings import ContactSettings
from ...run.errors import BadInput


class AnimateBad(BadInput):
    """The settings select no frame; give --fps 1 to 240 and --from before --to."""

    code = "animate.settings_bad"


@dataclass(frozen=True)
class StepLimits:
    """Describe the limits of a step of the wearer.

    Attributes:
        travel: Largest motion of skin near the cloth in a step [m], that of limbs of a brisk walk in a frame. A step of
            twice the motion takes as many solver runs, and the cloth of a walk differs by 1 mm (RMS) from that of two
            half steps.
        longest: Longest step [s].
    """

    travel: float = 0.06
    longest: float = 1.0 / 30.0


@dataclass(frozen=True)
class AnimateSettings:
    """Describe the settings of an animation.

    Attributes:
        fps: Frames a second [1/s].
        begin: Time of the motion at the first frame [s].
        end: Time of the motion at the last frame [s], exclusive if it loops; None: its end, or 4 s of one that loops.
        lead: Duration of the wearer's way from the own pose into the motion, before the first frame [s].
        pace: Limits of a step.
        lead_pace: Limits of a step of the lead-in, independent of `pace` and `fps`: new folds form in the lead-in, and
            their places depend on the steps (by 4 to 6 mm, however short). So a motion always has the same beginning.
        halvings: Largest number of times that a step which does not converge is halved.
        step: The steps.
        contact: The contact of cloth and body.
        self_contact: Whether the cloth is in contact with itself.
        keep_motion: Whether limbs are not spread, even where they leave the cloth no room.
    """

    fps: float = 30.0
    begin: float = 0.0
    end: float | None = None
    lead: float = 1.0
    pace: StepLimits = StepLimits()
    lead_pace: StepLimits = StepLimits()
    halvings: int = 3
    step: StepSettings = field(default_factory=StepSettings)
    contact: ContactSettings = field(default_factory=ContactSettings)
    self_contact: bool = True
    keep_motion: bool = False

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            AnimateBad: where one is outside its range.
        """
        if not 1.0 <= self.fps <= 240.0 or not 0.0 <= self.begin <= 3600.0 or not 0.0 <= self.lead <= 60.0:
            raise AnimateBad(f"fps {self.fps:g}, from {self.begin:g} s: {AnimateBad().message}")
        if self.end is not None and not self.begin < self.end <= 3600.0:
            raise AnimateBad(f"from {self.begin:g} s to {self.end:g} s: {AnimateBad().message}")
