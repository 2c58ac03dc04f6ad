"""What one may choose about an animation."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...cloth.motion_step import StepSettings
from ...cloth.settings import ContactSettings
from ...run.errors import BadInput


class AnimateBad(BadInput):
    """The choice of frames makes no animation; give --fps 1 to 240 and --from before --to."""

    code = "animate.settings_bad"


@dataclass(frozen=True)
class StepLimits:
    """Limit a step of the wearer.

    Attributes:
        travel: Furthest that skin near the cloth moves in a step [m]: limbs of a brisk walk go as far in a frame. A
            step of twice the way takes as many legs, and moves the cloth of a walk by 1 mm (RMS) against two of half
            of it.
        longest: Longest step [s].
    """

    travel: float = 0.06
    longest: float = 1.0 / 30.0


@dataclass(frozen=True)
class AnimateSettings:
    """Set an animation.

    Attributes:
        fps: Frames a second [1/s].
        begin: Time of the motion at the first frame [s].
        end: Time of the motion at which the frames end [s], that of the last one, or of one that loops the first left
            out; None: where it ends, or four seconds of one that loops.
        lead: Time in which the wearer goes from the own pose into the motion, before the first frame [s].
        pace: Limits of a step.
        lead_pace: Limits of a step of the lead-in, whatever `pace` and `fps` are: cloth folds anew while the wearer
            goes into the motion, and where it folds hangs on the steps (by 4 to 6 mm, be they ever so short). So one
            motion has one beginning.
        halvings: Times that a step which does not converge is halved.
        step: The steps.
        contact: How the cloth touches the body.
        apart: Whether the cloth keeps from passing through itself.
        keep_motion: Whether limbs stay where the motion has them, though they leave the cloth no room.
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
    apart: bool = True
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
