"""Animate a stored garment on its wearer, and judge the result."""

from __future__ import annotations

from dataclasses import dataclass

from ...body.motion.recording import Recording
from ...body.motion.retarget import retarget
from ...body.motion.track import LeadIn, Pose
from ...run.clock import Clock
from ...run.report import ResultReport
from ..wear.worn import WornGarment
from .animation import STAGE, Animation, animate
from .clearing import make_room_for_garment
from .measured import judge_animation, judge_motion, measure_animation
from .settings import AnimateSettings


@dataclass(frozen=True)
class AnimatedGarment:
    """Describe a garment in motion: the frames, the motion's name, and the report."""

    animation: Animation
    motion: str
    report: ResultReport


def animate_garment(
    worn: WornGarment, recording: Recording, name: str, settings: AnimateSettings, clock: Clock
) -> AnimatedGarment:
    """Animate a garment on its wearer by a recording.

    Args:
        worn: The garment of a stored result.
        recording: The motion of the file.
        name: Name of the motion.
        settings: Frames and steps.
        clock: Times the stages.

    Raises:
        AnimateBad: where there would be no frame, or more than can be kept.
        Cancelled: where the clock's hooks cancel.
    """
    with clock.stage(STAGE, "moving the wearer") as hooks:
        track, clearing = retarget(recording, worn.body, settings.begin), None
        if not settings.keep_motion:
            hooks.progress(STAGE, 0.0, "making room between the limbs")
            track, clearing = make_room_for_garment(worn, track, settings)
        lead = LeadIn(Pose.of(worn.body), track, settings.begin, settings.lead)
        animation = animate(worn, lead, settings, hooks)
    with clock.stage("measure", "judging the frames"):
        metrics = measure_animation(animation)
    warnings = [*recording.notes, *(clearing.warnings() if clearing is not None else ())]
    metrics["limbs_spread_deg"] = max(clearing.degrees.values()) if clearing is not None else 0.0
    if not track.loops and float(animation.times[-1]) > track.seconds + 1e-6:
        warnings.append(f"the motion is over after {track.seconds:.2f} s; after that the wearer stands still.")
    if worn.rotation is not None:
        warnings.append("the scanned cloth was in motion; here it moves from rest.")
    manifest = {
        "motion": name,
        "fps": settings.fps,
        "from": float(animation.times[0]),
        "to": float(animation.times[-1]),
        "damping_per_s": settings.step.damping,
        "keep_motion": settings.keep_motion,
        "limbs_spread_deg": {} if clearing is None else clearing.degrees,
        "body": worn.body.source,
        "fabric": worn.fabric.name,
        "template": worn.template,
        "category": worn.category,
    }
    gates = (judge_motion(recording), *judge_animation(metrics))
    return AnimatedGarment(animation, name, ResultReport.of(clock, metrics, gates, warnings, manifest))
