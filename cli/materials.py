"""`garmentq materials`: the shipped fabrics, and imported ones."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import home_option, json_option
from .output import NewFile, writing

if TYPE_CHECKING:
    from ..service.backend import Backend

PARAMETERS = ("H00", "H01", "H11", "H22", "k", "thickness", "friction")


class Library(click.Group):
    """Run `list` if no command is named: `materials denim` is `materials list denim`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Insert `list` before arguments that are not a command."""
        if not args or args[0] not in (*self.commands, *ctx.help_option_names):
            args = ["list", *args]
        return super().parse_args(ctx, args)


@click.group("materials", cls=Library)
def command() -> None:
    """List, show, import, export and delete fabrics.

    \b
    Example:
      garmentq materials
      garmentq materials denim --json
      garmentq materials export denim -o mine.json
      garmentq materials import mine.json
    """


@command.command("list")
@click.argument("name", required=False)
@home_option
@json_option
def list_command(name: str | None, home: Path | None, as_json: bool) -> None:
    """List the fabrics of the library.

    With a name: all its parameters in SI units, and the source of each.

    \b
    Example:
      garmentq materials list
      garmentq materials list denim --json
    """
    from ..service.catalogue import show_fabric
    from .terminal import print_json, print_table

    backend = _open(home)
    fabrics = [backend.read_material(name)] if name else backend.list_materials()
    if as_json:
        for fabric in fabrics:
            print_json(show_fabric(fabric))
        return
    print_table(
        ["name", "title", "g/m2", "H00 N/m", "H01 N/m", "H11 N/m", "H22 N/m", "k N m", "thickness m", "friction"],
        [[f.name, f.title, f.density * 1000, *(getattr(f, n) for n in PARAMETERS)] for f in fabrics],
    )
    if name:
        print_table(["parameter", "source"], list(fabrics[0].sources))


@command.command("import")
@click.argument("file", type=click.Path(path_type=Path))
@home_option
@json_option
def import_command(file: Path, home: Path | None, as_json: bool) -> None:
    """Import the fabrics of a JSON or CSV file.

    Each number has a unit and a source. An imported fabric of the same name is replaced; jobs that use it keep its
    numbers.

    \b
    Example:
      garmentq materials import mine.json
    """
    from ..service.catalogue import show_fabric
    from .terminal import print_json, print_note

    for fabric in _open(home).import_materials(file):
        if as_json:
            print_json(show_fabric(fabric))
        else:
            print_note(f"imported '{fabric.name}': {fabric.density * 1000:.0f} g/m2, k {fabric.k:.3g} N m")


@command.command("export")
@click.argument("names", nargs=-1, required=True)
@click.option("-o", "--out", type=NewFile(), required=True, help="JSON or CSV file.")
@home_option
def export_command(names: tuple[str, ...], out: Path, home: Path | None) -> None:
    """Write fabrics as a JSON or CSV file, with units and sources.

    \b
    Example:
      garmentq materials export denim canvas -o mine.csv
    """
    from ..core.cloth.fabric_file import write_fabrics

    backend = _open(home)
    fabrics = [backend.read_material(name) for name in dict.fromkeys(names)]
    with writing(out):
        write_fabrics(fabrics, out)
    click.echo(str(out))


@command.command("delete")
@click.argument("name")
@home_option
def delete_command(name: str, home: Path | None) -> None:
    """Delete an imported fabric.

    Jobs that use it keep its numbers; a shipped fabric cannot be deleted.

    \b
    Example:
      garmentq materials delete mine
    """
    from .terminal import print_note

    _open(home).delete_material(name)
    print_note(f"deleted '{name}'")


def _open(home: Path | None) -> Backend:
    from ..service.backend import open_backend
    from ..service.settings import read_settings

    return open_backend(read_settings(home=home))
