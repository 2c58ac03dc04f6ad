"""The request of an animation; the module is light, because the limited process that reads its file imports it."""

from __future__ import annotations

from dataclasses import dataclass

from ...core.body.motion.shipped import SHIPPED_MOTIONS
from .request import FileRef, RequestBad

MOTION = "motion.npz"
"""File with the arrays of the motion, beside its folder."""


@dataclass(frozen=True)
class AnimateRequest:
    """Describe an animation of a stored result.

    Attributes:
        motion: A motion's file, or the name of a shipped one.
        fps: Frame rate [1/s].
        begin: Time of the motion at the first frame [s].
        end: Time of the motion at which the frames end [s]: that of the last frame, or for a looping motion that of the
            first frame, which is not repeated; None: its end, or four seconds of a looping one.
        damping: Rate at which velocity relative to the air decays [1/s], or None: the default.
        keep_motion: Whether limbs follow the motion even if they leave the cloth no room.
    """

    motion: FileRef | str
    fps: float = 30.0
    begin: float = 0.0
    end: float | None = None
    damping: float | None = None
    keep_motion: bool = False

    def __post_init__(self) -> None:
        """Refuse an invalid request.

        Raises:
            RequestBad: if the motion is neither a file nor shipped.
            AnimateBad: if the frames make no animation.
        """
        from ...core.reuse.animate.settings import AnimateBad, AnimateSettings

        if isinstance(self.motion, str) and self.motion not in SHIPPED_MOTIONS:
            raise RequestBad(
                f"no motion '{self.motion[:40]}' is shipped; there are {', '.join(SHIPPED_MOTIONS)}, and files."
            )
        if self.damping is not None and not 0.0 <= self.damping <= 100.0:
            raise AnimateBad(f"a damping of {self.damping:g} a second is outside 0 to 100.")
        AnimateSettings(fps=self.fps, begin=self.begin, end=self.end)
