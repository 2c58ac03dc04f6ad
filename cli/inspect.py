"""`garmentq inspect`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .labels import LabelOptions, label_options
from .options import json_option


@click.command("inspect")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--body", help="The wearer's mesh file, or builtin:female,height=1.70.")
@label_options
@click.option("--units", type=click.Choice(["m", "cm", "mm"]), help="Unit of the files.  [default: found]")
@click.option("--up", type=click.Choice(["y", "z"]), help="Up axis of the files.  [default: found]")
@json_option
def command(
    file: Path,
    body: str | None,
    part: LabelOptions,
    units: str | None,
    up: str | None,
    as_json: bool,
) -> None:
    """Show how a file is understood, before anything is run.

    Units, up axis, extent, what was repaired; with a body also its contours, holes and category. Of a dressed person's
    scan the garment that --labels, --keep or --keep-colour says is cut out, and the body is estimated from the skin.

    \b
    Example:
      garmentq inspect garment.ply --body body.ply
      garmentq inspect person.ply --labels labels.npz --keep 1
    """
    from ..core.body import is_builtin
    from ..core.recovery import make_selection
    from ..core.segment import inspect_file
    from ..core.settings import RecoverySettings
    from .terminal import print_json, print_table

    wearer: Path | str | None = body if body is None or is_builtin(body) else Path(body)
    chosen = RecoverySettings(
        keep=part.keep,
        cloth=part.cloth,
        labels_key=part.labels_key,
        keep_colour=part.keep_colour,
        colour_tolerance=part.colour_tolerance,
    )
    selection = make_selection(part.labels, chosen)
    found = inspect_file(file, wearer, units=units, up=up, selection=selection).as_dict()
    if as_json:
        print_json(found)
        return
    print_table(["", ""], _rows(found))


def _rows(found: dict[str, Any], before: str = "") -> list[list[object]]:
    """Flatten nested values to one row each."""
    rows: list[list[object]] = []
    for name, value in found.items():
        if isinstance(value, dict):
            rows += _rows(value, f"{before}{name}.")
        elif isinstance(value, list | tuple) and value and all(isinstance(item, dict) for item in value):
            for item in value:
                label = str(item.get("name", len(rows)))
                rows += _rows({k: v for k, v in item.items() if k != "name"}, f"{before}{name}.{label}.")
        elif isinstance(value, list | tuple):
            rows.append([before + name, ", ".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in value)])
        else:
            rows.append([before + name, value])
    return rows
