"""`garmentq inspect`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..core.body.spec import Wearer, read_wearer
from ..core.run.units import UNITS
from ..service.order import GARMENT, GIVEN_AS, PERSON
from .labels import LabelOptions, label_options
from .options import AXES, height_option, json_option

if TYPE_CHECKING:
    from ..core.scan.selection import Selection


@click.command("inspect")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--as",
    "given_as",
    type=click.Choice(GIVEN_AS),
    help="What the file is.  [default: detected; docs/reference/cli.md]",
)
@click.option("--body", help="The wearer's mesh file, or builtin:female,height=1.70.")
@label_options
@click.option("--units", type=click.Choice(tuple(UNITS)), help="Unit of the files.  [default: detected]")
@click.option("--up", type=click.Choice(AXES), help="Up axis of the files.  [default: detected]")
@height_option
@json_option
def command(
    file: Path,
    given_as: str | None,
    body: str | None,
    part: LabelOptions,
    units: str | None,
    up: str | None,
    height: float | None,
    as_json: bool,
) -> None:
    """Show what is detected in a file, before a job is run.

    Shows whether it is a whole person or a garment, units, up axis, extent and repairs; with a body also its contours,
    holes and category. From a dressed person's scan the garment given by --labels, --keep or --keep-colour is cut out,
    and the body is fitted below the clothes. `garmentq segment` segments a person.

    \b
    Example:
      garmentq inspect scan.ply
      garmentq inspect garment.ply --body body.ply
      garmentq inspect person.ply --labels labels.npz --keep 1
    """
    from ..core.recover.recovery import make_selection
    from ..core.recover.settings import RecoverySettings
    from .terminal import print_json, print_table

    chosen = RecoverySettings(
        keep=part.keep,
        cloth=part.cloth,
        labels_key=part.labels_key,
        keep_colour=part.keep_colour,
        colour_tolerance=part.colour_tolerance,
    )
    selection = make_selection(part.labels, chosen)
    found = _inspect_file(_InspectionOptions(file, read_wearer(body), given_as, units, up, height), selection)
    if as_json:
        print_json(found)
        return
    print_table(["", ""], _rows(found))


@dataclass(frozen=True)
class _InspectionOptions:
    """Describe the options: the file, its wearer, what it is, its unit, axis and height."""

    file: Path
    body: Wearer | None
    given_as: str | None
    units: str | None
    up: str | None
    height: float | None


def _inspect_file(options: _InspectionOptions, selection: Selection | None) -> dict[str, Any]:
    """Return what is detected in a file.

    Raises:
        BadInput: if it cannot be used.
    """
    from ..core.run.errors import BadInput
    from ..service.inspect_garment import inspect_file
    from ..service.inspect_scan import classify_file, explain_missing_body, inspect_person, is_garment_refusal
    from .terminal import print_note

    what = options.given_as or GARMENT
    if options.given_as is None and selection is None:
        body = options.body
        what = PERSON if body is None else classify_file(options.file, body, options.units, options.up)
    if what == PERSON:
        try:
            return inspect_person(options.file, options.units, options.up, options.height)
        except BadInput as error:
            if options.given_as == PERSON or options.body is not None or not is_garment_refusal(error):
                raise
            print_note(explain_missing_body(error))
    found = inspect_file(options.file, options.body, units=options.units, up=options.up, selection=selection).as_dict()
    return {"as": GARMENT, **found}


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
