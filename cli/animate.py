"""`garmentq animate`."""

from __future__ import annotations

from pathlib import Path

import click

from ..core.body.motion.shipped import SHIPPED_MOTIONS
from .derived import DerivedOptions, derived_options


@click.command("animate")
@click.argument("job")
@click.option(
    "--motion",
    required=True,
    help=f"A .bvh, .npz or .json file (docs/howto/animate.md), or {', '.join(SHIPPED_MOTIONS)}.",
)
@click.option("--fps", type=click.FloatRange(1, 240), default=30.0, show_default=True, help="Frames a second.")
@click.option("--from", "begin", type=click.FloatRange(0), default=0.0, show_default=True, help="Start time [s].")
@click.option("--to", "end", type=click.FloatRange(0), help="End time [s].  [default: its end; 4 s if it loops]")
@click.option("--damping", type=click.FloatRange(0, 100), help="Air drag, 1/s.  [default: 2]")
@click.option(
    "--keep-motion", is_flag=True, help="Keep the limbs of the motion even if they leave no room for the cloth."
)
@derived_options
@click.pass_context
def command(
    context: click.Context,
    job: str,
    motion: str,
    fps: float,
    begin: float,
    end: float | None,
    damping: float | None,
    keep_motion: bool,
    options: DerivedOptions,
) -> None:
    """Move a stored result with its wearer.

    The wearer of a recovery, or of a result of `garmentq dress`, performs a motion, and the cloth follows. Prints the
    id of the job; with --wait the result: whether every frame converged, is outside the body and does not cross itself.
    Files: point caches (PC2, MDD), a GLB and a USD animation, a contact sheet, a preview.

    \b
    Example:
      garmentq animate 3685ecfd4f81 --motion walk --wait
      garmentq animate 3685ecfd4f81 --motion dance.bvh --fps 24 --from 1 --to 5 --out danced
      garmentq query --where 'max_depth_mm < 2' --where 'kind = animate'
    """
    from ..service.derived import DerivedOrder
    from .derived import run_derived

    chosen = {"motion": motion if motion in SHIPPED_MOTIONS else None, "fps": fps, "begin": begin, "end": end}
    fields = {
        name: value
        for name, value in {**chosen, "damping": damping, "keep_motion": keep_motion or None}.items()
        if value is not None
    }
    files = {} if motion in SHIPPED_MOTIONS else {"motion": Path(motion)}
    context.exit(run_derived(DerivedOrder("animate", job, fields, files), options))
