"""Options of a command on one garment of a dressed person's scan."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import click

from ..core.recover.settings import RecoverySettings
from .options import Decorator, gather


def _once(context: click.Context, parameter: click.Parameter, values: tuple[str, ...]) -> str | None:
    """Accept an option once, and refuse it if it is repeated: otherwise the last one would be used silently."""
    if len(values) > 1:
        raise click.BadParameter("one garment is shown at a time; give --keep once.")
    return values[0] if values else None


@dataclass(frozen=True)
class LabelOptions:
    """Describe the options about the part of a dressed person's scan that is the garment."""

    labels: Path | None
    labels_key: str | None
    keep: str | None
    cloth: str | None
    keep_colour: str | None
    colour_tolerance: float


def label_options(function: Decorator) -> Decorator:
    """Add the options about which part of a dressed person's scan is the garment; the command receives one `part`."""
    options = [
        click.option(
            "--labels",
            type=click.Path(path_type=Path),
            help="A dressed person's scan: one label per vertex, .npz .npy .json .txt.  [default: in the scan]",
        ),
        click.option("--labels-key", help="The array's name in that file.  [default: detected]"),
        click.option(
            "--keep", metavar="LABEL[,LABEL]", multiple=True, callback=_once, help="The garment's labels.  [default: 1]"
        ),
        click.option("--cloth", metavar="LABEL[,LABEL]", help="Labels of other clothes, which are not skin either."),
        click.option("--keep-colour", metavar="#RRGGBB", help="The garment's colour, instead of labels."),
        click.option(
            "--colour-tolerance",
            type=float,
            default=RecoverySettings().colour_tolerance,
            show_default=True,
            help="Distance in RGB, 0 to 255.",
        ),
    ]
    command: Decorator = gather(LabelOptions, options, "part")(function)
    return command
