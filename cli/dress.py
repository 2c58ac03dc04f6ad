"""`garmentq dress`."""

from __future__ import annotations

from pathlib import Path

import click

from ..core.body import is_builtin
from .derived import DerivedOptions, derived_options
from .options import AXES, UNITS


@click.command("dress")
@click.argument("job")
@click.option("--body", help="Who wears it: a mesh file, or builtin:male,height=1.85,weight=85.  [default: the wearer]")
@click.option(
    "--measures", type=click.Path(path_type=Path), help="Who wears it: a file of measures in cm, CSV or JSON."
)
@click.option("--pose", help="Pose of the body: T, A, arms-down, stride, seated.  [default: its own]")
@click.option("--fabric", help="A name from `garmentq materials`.  [default: the result's own]")
@click.option("--units", type=click.Choice(UNITS[:3]), help="Unit of the body's file.  [default: found]")
@click.option("--up", type=click.Choice(AXES[:2]), help="Up axis of the body's file.  [default: found]")
@derived_options
@click.pass_context
def command(
    context: click.Context,
    job: str,
    body: str | None,
    measures: Path | None,
    pose: str | None,
    fabric: str | None,
    units: str | None,
    up: str | None,
    options: DerivedOptions,
) -> None:
    """Dress another body in a stored result.

    The pattern stays as it is, and is draped on the other body in its own cloth or another one. Prints the id of the
    job; with --wait the result: whether the garment is at rest, outside the body, and wide enough.

    \b
    Example:
      garmentq dress 3685ecfd4f81 --body builtin:male,height=1.85,weight=85 --pose A --wait
      garmentq dress 3685ecfd4f81 --body body.ply --fabric denim --out dressed
      garmentq dress 3685ecfd4f81 --measures anna.csv --pose stride --wait --json
    """
    from ..service.derived import DerivedOrder
    from .derived import choose_body, run_derived

    body = choose_body(body, measures)
    given = {"body": body if is_builtin(body) else None, "pose": pose, "fabric": fabric, "units": units, "up": up}
    files = {} if body is None or is_builtin(body) else {"body": Path(body)}
    chosen = {name: value for name, value in given.items() if value is not None}
    context.exit(run_derived(DerivedOrder("dress", job, chosen, files), options))
