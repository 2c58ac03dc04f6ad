"""`garmentq segment`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import click

from ..core.body.spec import BuiltinWearer, read_wearer
from ..core.run.units import UNITS
from .options import Decorator, gather, height_option, json_option
from .output import NewFolder, writing


@dataclass(frozen=True)
class HintOptions:
    """Describe the options that override what is detected in a person's scan; each field is the option of its name."""

    labels: Path | None
    wearing: str | None
    mark: tuple[str, ...]
    body: str | None
    units: str | None
    up: str | None
    height: float | None


def hint_options(function: Decorator) -> Decorator:
    """Add the options that override what is detected in a scan; the command receives one `options: HintOptions`."""
    options = [
        click.option(
            "--labels", type=click.Path(path_type=Path), help="A labels file with names, as this command writes it."
        ),
        click.option("--wearing", metavar="PART[,PART]", help="What is worn: upper, lower, one-piece, outer; nothing."),
        click.option("--mark", multiple=True, metavar="PART=X,Y,Z", help="Part at a point, in the file's coordinates."),
        click.option("--body", help="The wearer's file in the scan's pose, or builtin:...  [default: fitted]"),
        click.option("--units", type=click.Choice(tuple(UNITS)), help="Unit of the files.  [default: detected]"),
        click.option("--up", type=click.Choice(["y", "z"]), help="Up axis of the files.  [default: detected]"),
        height_option,
    ]
    command: Decorator = gather(HintOptions, options)(function)
    return command


@click.command("segment")
@click.argument("scan", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=NewFolder(), help="Folder for the files.")
@hint_options
@json_option
def command(scan: Path, out: Path, options: HintOptions, as_json: bool) -> None:
    """Label skin, hair, shoes and garments of a person's scan, and fit the body under the clothes.

    Writes labels.npz, segmented.ply, scan.ply, body.ply and picture.png. If the confidence is too low to recover
    anything it writes them too, and ends with status 4 and a code. Corrected labels are given by --labels.

    \b
    Example:
      garmentq segment person.ply --out parts
      garmentq segment person.ply --out parts --wearing one-piece
    """
    from ..core.deliver.export.person import write_person
    from ..core.people.hints import Hints, parse_mark, parse_wearing
    from ..core.people.person_input import PersonFiles, read_person_input
    from ..core.people.pipeline import register_given_body
    from ..core.people.separate import label_person
    from ..core.run.hooks import SILENT_HOOKS
    from ..service.describe_person import describe_person
    from .terminal import print_json, print_note, print_table

    wearing = None if options.wearing is None else parse_wearing(options.wearing)
    marks = tuple(parse_mark(mark) for mark in options.mark)
    wearer = read_wearer(options.body)
    body = wearer if isinstance(wearer, Path) else None
    inputs = PersonFiles(scan, options.labels, body, units=options.units, up=options.up, height=options.height)
    content = read_person_input(inputs)
    raw = content.raw
    built_in = wearer if isinstance(wearer, BuiltinWearer) else None
    separation = label_person(
        raw, Hints(content.label, wearing, marks, register_given_body(content, built_in, SILENT_HOOKS))
    )
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
        files = write_person(raw, separation, out)
    found = describe_person(raw, separation) | {"files": [str(path) for path in files]}
    if as_json:
        print_json(found)
    else:
        inferred = [[c.name for c in garment.contours if c.is_inferred] for garment in separation.garments]
        rows = [
            [garment.part.word, garment.category, f"{garment.confidence:.2f}", ", ".join(names)]
            for garment, names in zip(separation.garments, inferred, strict=True)
        ]
        print_table(["garment", "category", "confidence", "inferred openings"], rows)
        for line in (*found["warnings"], *(f"wrote {path}" for path in files)):
            print_note(line)
    if separation.problem is not None:
        raise separation.problem
