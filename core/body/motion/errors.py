"""Errors of motions."""

from __future__ import annotations

from ...run.errors import BadInput


class MotionBad(BadInput):
    """The file is not a known kind of motion; give BVH, .npz of poses, or JSON keys (docs/howto/animate.md)."""

    code = "motion.bad"


class MotionTooLarge(BadInput):
    """The motion is too long or has too many joints; cut it to what is needed."""

    code = "motion.too_large"


class MotionForeign(BadInput):
    """The skeleton is not recognised; give one whose hips, knees and feet are named as docs/howto/animate.md says."""

    code = "motion.foreign"
