"""Write a garment in motion into one folder: point caches, a GLB that plays, pictures, verdicts."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...reuse.animate.animate_garment import AnimatedGarment
from ...reuse.animate.animation import Animation
from .animation_report import report_animation
from .meshes import write_meshes, write_ply
from .morph_glb import MAX_ANIMATION_FILE_BYTES, morph_bytes, write_morphs
from .motion_pictures import write_preview, write_sheet
from .point_caches import write_mdd, write_pc2
from .result import write_json
from .usd_mesh import USD_MISSING_WARNING, can_write_usd, write_usd


def write_animation(animation: Animation, folder: Path) -> list[Path]:
    """Write caches, meshes, pictures and verdicts of an animation.

    Args:
        animation: The animation.
        folder: Folder, created if missing; files of the same names are replaced.

    Returns:
        The files: garment.obj and garment.ply (the first frame, in the vertex order of the caches), garment.pc2,
            garment.mdd, garment.glb (left out above `MAX_ANIMATION_FILE_BYTES`), garment.usdc (left out without the
            extra `usd`), sheet.png, preview.gif, frames.json.
    """
    folder.mkdir(parents=True, exist_ok=True)
    garment, frames = animation.worn.garment, animation.frames
    files = write_meshes(garment, frames[0], folder, "garment", ("obj", "ply"))
    files.append(write_pc2(frames, folder / "garment.pc2"))
    files.append(write_mdd(frames, animation.fps, folder / "garment.mdd"))
    if morph_bytes(garment, frames) <= MAX_ANIMATION_FILE_BYTES:
        files.append(write_morphs(garment, frames, animation.fps, folder / "garment.glb"))
    if can_write_usd():
        files.append(write_usd(garment, frames, folder / "garment.usdc", animation.fps))
    files.append(write_sheet(animation, folder / "sheet.png"))
    files.append(write_preview(animation, folder / "preview.gif"))
    verdicts = folder / "frames.json"
    verdicts.write_text(json.dumps(describe_frames(animation), indent=1) + "\n", encoding="utf-8")
    return [*files, verdicts]


def add_omission_warnings(moved: AnimatedGarment) -> AnimatedGarment:
    """Return an animation with a warning for each file that `write_animation_result` leaves out."""
    animation, warnings = moved.animation, []
    if not can_write_usd():
        warnings.append(USD_MISSING_WARNING)
    if morph_bytes(animation.worn.garment, animation.frames) > MAX_ANIMATION_FILE_BYTES:
        warnings.append(
            f"no GLB: it would be larger than {MAX_ANIMATION_FILE_BYTES // 10**6} MB; the point caches hold all frames."
        )
    if _body_bytes(animation) > MAX_ANIMATION_FILE_BYTES:
        warnings.append(
            f"no body.pc2: it would be larger than {MAX_ANIMATION_FILE_BYTES // 10**6} MB; take a part of the motion."
        )
    report = replace(moved.report, warnings=(*moved.report.warnings, *warnings))
    return replace(moved, report=report)


def _body_bytes(animation: Animation) -> int:
    """Estimate the size of the wearer's point cache [bytes]."""
    return 4 * animation.worn.body.vertices.size * len(animation.frames)


def write_animation_result(moved: AnimatedGarment, folder: Path) -> list[Path]:
    """Write an animation with its numbers and report.

    Returns:
        The files: those of `write_animation`, body.ply (the wearer at the start), body.pc2 (the wearer's mesh in each
            frame; left out above `MAX_ANIMATION_FILE_BYTES`), metrics.json, manifest.json, report.html.
    """
    files, animation = write_animation(moved.animation, folder), moved.animation
    body = animation.worn.body
    files.append(write_ply(body.vertices, body.faces, folder / "body.ply"))
    if _body_bytes(animation) <= MAX_ANIMATION_FILE_BYTES:
        files.append(write_pc2(animation.bodies(), folder / "body.pc2"))
    files.append(write_json(moved.report.metrics, folder / "metrics.json"))
    files.append(write_json(moved.report.manifest, folder / "manifest.json"))
    report = folder / "report.html"
    preview, sheet = ((folder / name).read_bytes() for name in ("preview.gif", "sheet.png"))
    report.write_text(report_animation(moved, preview, sheet), encoding="utf-8")
    return [*files, report]


def describe_frames(animation: Animation) -> dict[str, Any]:
    """Return rate, times and verdicts as JSON values; units in the names."""
    return {
        "fps": animation.fps,
        "vertices": animation.frames.shape[1],
        "frames": [
            {
                "t": round(float(time), 6),
                "converged": verdict.converged,
                "depth_mm": round(1e3 * verdict.depth, 4),
                "pinched_mm": round(1e3 * verdict.pinched, 4),
                "crossings": verdict.crossings,
                "steps": verdict.steps,
                "cpu_seconds": round(verdict.seconds, 3),
            }
            for time, verdict in zip(animation.times, animation.verdicts, strict=True)
        ],
    }
