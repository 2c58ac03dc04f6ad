"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Any

import click

from ..core.cloth.fabrics import DEFAULT_FABRIC
from ..core.recover.settings import METHODS, PRESETS, QUALITIES, REDRAPES, STATURE_RANGE, RecoverySettings
from ..core.run.units import UNITS
from ..service.order import GIVEN_AS
from .output import NewFolder, keep_private

Decorator = Callable[..., Any]

AXES = ("y", "z", "-y", "-z")
"""Axes of files that may point up; the last two only for persons."""

home_option = click.option(
    "--home",
    callback=keep_private,
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the database, the store and the logs.  [default: ~/.local/share/garmentq]",
)
known_home_option = click.option(
    "--home",
    callback=keep_private,
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Folder of the database, the store and the logs; it must exist.  [default: ~/.local/share/garmentq]",
)
"""For commands that only read: a mistyped home must not count as an empty one."""
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object a line.")
verbose_option = click.option("--verbose", is_flag=True, help="Show every metric, check, warning and file.")
workers_option = click.option(
    "--workers", type=click.IntRange(1, 256), help="Jobs at a time, if a worker is started.  [default: cores]"
)
height_option = click.option(
    "--height",
    type=click.FloatRange(*STATURE_RANGE),
    metavar="METRES",
    help="Height of the scanned person, standing, where the file has no unit.",
)
out_option = click.option("--out", "-o", type=NewFolder(), default=Path("."), help="Folder.  [default: here]")
timeout_option = click.option(
    "--timeout", type=click.FloatRange(min=0.0), help="Stop waiting after this many seconds; the job continues."
)
allow_host_option = click.option(
    "--allow-host", multiple=True, metavar="NAME", envvar="GARMENTQ_API_ALLOW_HOST",
    help="Host name under which a proxy on this machine calls the API; may be repeated.",
)  # fmt: skip
lenient_option = click.option("--lenient", is_flag=True, help="Exit with 0 even if a result fails a check.")


def gather(record: type, options: Sequence[Decorator], name: str = "options") -> Decorator:
    """Return a decorator that adds options to a command, which receives them as one record with a field for each."""

    def decorate(function: Decorator) -> Decorator:
        @wraps(function)
        def collect(*words: Any, **values: Any) -> Any:
            typed = record(**{item.name: values.pop(item.name) for item in fields(record)})
            return function(*words, **{name: typed}, **values)

        command: Decorator = collect
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


@dataclass(frozen=True)
class WaitOptions:
    """Describe the options about waiting for jobs; each field is the option of its name."""

    timeout: float | None
    lenient: bool


wait_options = gather(WaitOptions, [timeout_option, lenient_option], "waiting")


def method_options(is_beside_quality: bool = False) -> list[Decorator]:
    """Return the options about the recovery method, which is None beside a quality if it is not given."""
    default = RecoverySettings()
    return [
        click.option(
            "--method",
            type=click.Choice(METHODS),
            default=None if is_beside_quality else default.method,
            show_default=True,
            help=f"Recovery method.{'  [default: that of the quality]' if is_beside_quality else ''}",
        ),
        click.option(
            "--preset",
            type=click.Choice(PRESETS),
            default=default.preset,
            show_default=True,
            help="Weights of the deformation.",
        ),
    ]


@dataclass(frozen=True)
class OrderOptions:
    """Describe the options of a recovery; each field is the option of its name.

    `template`, `garment`, `fabric` and `lock` may have a part in front, as in `upper:denim`.
    """

    given_as: str | None
    wearing: str | None
    mark: tuple[str, ...]
    body: str | None
    labels: Path | None
    labels_key: str | None
    keep: tuple[str, ...]
    cloth: tuple[str, ...]
    keep_colour: str | None
    colour_tolerance: float
    template: tuple[str, ...]
    garment: tuple[str, ...]
    fabric: tuple[str, ...]
    lock: tuple[str, ...]
    free: str | None
    part: tuple[str, ...]
    keep_cut: bool
    quality: str | None
    method: str | None
    preset: str
    units: str | None
    up: str | None
    height: float | None
    vertices: int | None
    seed: int
    redrape: str | None
    force: bool
    name: str
    subject: str
    tags: tuple[str, ...]


def order_options(function: Decorator) -> Decorator:
    """Add the options of a recovery; the command receives them as one `options: OrderOptions`."""
    default = RecoverySettings()
    options = [
        click.option(
            "--as",
            "given_as",
            type=click.Choice(GIVEN_AS),
            help="What the file is (docs/reference/cli.md).  [default: detected]",
        ),
        click.option("--wearing", metavar="PART[,PART]", help="Exactly what is worn; or nothing.  [default: detected]"),
        click.option(
            "--mark", multiple=True, metavar="PART=X,Y,Z", help="Part of a person at a point, in the file's units."
        ),
        click.option("--body", help="The wearer's mesh file, or builtin:female,height=1.70."),
        click.option(
            "--labels",
            type=click.Path(path_type=Path),
            help="A dressed person's scan: one label per vertex, .npz .npy .json .txt.  [default: in the scan]",
        ),
        click.option("--labels-key", help="The array's name in that file.  [default: detected]"),
        click.option("--keep", multiple=True, metavar="LABEL[,LABEL]", help="The garment's labels.  [default: 1]"),
        click.option(
            "--cloth",
            multiple=True,
            metavar="LABEL[,LABEL]",
            help="Labels of other clothes, which are not skin either.  [default: those of other --keep]",
        ),
        click.option("--keep-colour", metavar="#RRGGBB", help="The garment's colour, instead of labels."),
        click.option(
            "--colour-tolerance",
            type=float,
            default=default.colour_tolerance,
            show_default=True,
            help="Distance in RGB, 0 to 255.",
        ),
        click.option(
            "--template",
            multiple=True,
            metavar="[PART:]FILE|NAME",
            help="Base pattern: a pattern file, or a template's name.  [default: chosen]",
        ),
        click.option(
            "--garment",
            multiple=True,
            metavar="[PART:]NAME",
            help="Category, overriding the detected one: tshirt, tank, dress, trousers, skirt, ...",
        ),
        click.option(
            "--fabric",
            multiple=True,
            metavar="[PART:]NAME",
            help=f"A name from `garmentq materials`.  [default: {DEFAULT_FABRIC}]",
        ),
        click.option(
            "--lock",
            multiple=True,
            metavar="[PART:]fabric|panel:NAME|point:PANEL/INDEX",
            help="Parameter that the fit keeps fixed; may be repeated.",
        ),
        click.option("--free", type=click.Choice(["symmetry"]), help="Allow left and right to differ."),
        click.option(
            "--part",
            multiple=True,
            metavar="[PART:]NAME=CHOICE",
            help="Part of the cut, overriding the detected one: neckline=v; see `templates list --parts`.",
        ),
        click.option("--keep-cut", is_flag=True, help="Add no dart to the base pattern's panels, and close none."),
        click.option(
            "--quality",
            type=click.Choice(tuple(QUALITIES)),
            help="Preview fits no pattern, in a third of the time; fine has smaller folds.  [default: standard]",
        ),
        *method_options(is_beside_quality=True),
        click.option("--units", type=click.Choice(tuple(UNITS)), help="Unit of the files.  [default: detected]"),
        click.option("--up", type=click.Choice(AXES), help="Up axis of the files.  [default: detected]"),
        height_option,
        click.option(
            "--vertices",
            type=click.IntRange(500, 20000),
            help="Vertices of the garment mesh.  [default: those of the quality]",
        ),
        click.option("--seed", type=int, default=default.seed, show_default=True, help="Seed of measured samples."),
        click.option(
            "--redrape",
            type=click.Choice(REDRAPES),
            help="Dress the pattern anew in the job, in one below it, or not.  [default: wait; submit: later]",
        ),
        click.option("--force", is_flag=True, help="Create a new job even if an equal one exists."),
        click.option("--name", default="", help="Name of the job and of all below it.  [default: the scan's]"),
        click.option("--subject", default="", metavar="NAME", help="Person who was scanned; a new name creates one."),
        click.option("--tag", "tags", multiple=True, help="Tag by which they are found; may be repeated."),
    ]
    command: Decorator = gather(OrderOptions, options)(function)
    return command
