"""Measure an animation by its worst frame and its cost, and judge whether it may be used."""

from __future__ import annotations

from ...body.motion.recording import Recording
from ...run.verdict import Gate, Verdict
from .animation import Animation

MAX_MOTION_DEPTH_MM = 2.0
"""Largest depth in the body that passes in any frame [mm]; in motion it is not visible."""

LIMBS = ("left_hip", "right_hip", "left_shoulder", "right_shoulder", "spine3")
"""Joints without which a whole limb, or the trunk, does not follow the motion, and the garment is wrong there."""


def measure_animation(animation: Animation) -> dict[str, float | None]:
    """Measure the worst of all frames, and the mean cost; units in the names."""
    verdicts = animation.verdicts
    return {
        "frames": float(len(verdicts)),
        "vertices": float(animation.frames.shape[1]),
        "max_depth_mm": 1e3 * max(verdict.depth for verdict in verdicts),
        "max_pinched_mm": 1e3 * max(verdict.pinched for verdict in verdicts),
        "frames_pinched": float(sum(1e3 * verdict.pinched > MAX_MOTION_DEPTH_MM for verdict in verdicts)),
        "crossings": float(max(verdict.crossings for verdict in verdicts)),
        "frames_crossed": float(sum(verdict.crossings > 0 for verdict in verdicts)),
        "frames_not_converged": float(sum(not verdict.converged for verdict in verdicts)),
        "seconds_per_frame": sum(verdict.seconds for verdict in verdicts) / len(verdicts),
        "steps_per_frame": sum(verdict.steps for verdict in verdicts) / len(verdicts),
    }


def judge_animation(metrics: dict[str, float | None]) -> tuple[Gate, ...]:
    """Judge the metrics of `measure_animation`."""
    depth, crossed, left, pinched = (
        metrics[name] or 0.0 for name in ("max_depth_mm", "crossings", "frames_not_converged", "max_pinched_mm")
    )
    return (
        Gate(
            "converged",
            Verdict.PASS if left == 0 else Verdict.DOUBTFUL,
            left,
            0.0,
            "Every step of every frame converged."
            if left == 0
            else f"{left:.0f} frames hold a step that did not converge: look at them (frames.json names them).",
        ),
        Gate(
            "depth",
            Verdict.PASS if depth <= MAX_MOTION_DEPTH_MM else Verdict.DOUBTFUL,
            depth,
            MAX_MOTION_DEPTH_MM,
            f"The cloth lies up to {depth:.1f} mm inside the body"
            + (
                "."
                if depth <= MAX_MOTION_DEPTH_MM
                else " in a frame: it has no way out that does not lead through other cloth."
            ),
        ),
        Gate(
            "pinched",
            Verdict.PASS if pinched <= MAX_MOTION_DEPTH_MM else Verdict.DOUBTFUL,
            pinched,
            MAX_MOTION_DEPTH_MM,
            "Parts of the body leave the cloth room."
            if pinched <= MAX_MOTION_DEPTH_MM
            else f"Parts of the body run into each other and hold cloth up to {pinched:.1f} mm inside "
            f"({metrics['frames_pinched']:.0f} frames): give the motion more room there.",
        ),
        Gate(
            "crossings",
            Verdict.PASS if crossed == 0 else Verdict.DOUBTFUL,
            crossed,
            0.0,
            "No face passes through another in any frame."
            if crossed == 0
            else f"Up to {crossed:.0f} faces pass through others in a frame (frames.json names them).",
        ),
    )


def judge_motion(recording: Recording) -> Gate:
    """Judge whether a motion moves every limb, the trunk and the head; those that its skeleton lacks do not move."""
    missing = recording.missing()
    verdict = Verdict.FAIL if any(name in LIMBS for name in missing) else Verdict.DOUBTFUL if missing else Verdict.PASS
    message = " ".join(recording.doubts()) or "The motion moves the trunk and every limb."
    return Gate("motion", verdict, float(len(missing)), 0.0, message)
