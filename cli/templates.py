"""`garmentq templates`: the shipped base patterns, and imported ones."""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import click

from ..core.run.units import UNITS
from .options import home_option, json_option
from .output import NewFile, writing

if TYPE_CHECKING:
    from ..core.garment.pattern import Pattern
    from ..service.backend import Backend


@click.group("templates")
def command() -> None:
    """List, show, import, export and delete template patterns.

    \b
    Example:
      garmentq templates list
      garmentq templates import jacket.json --name jacket
      garmentq run scan.ply --body body.ply --template jacket
    """


@command.command("list")
@click.option("--parts", is_flag=True, help="List the parts of a cut, with the choices of each.")
@home_option
@json_option
def list_command(parts: bool, home: Path | None, as_json: bool) -> None:
    """List the templates, or the parts by which their cut can be changed.

    A name may have other parts after a plus sign, wherever a template is named.

    \b
    Example:
      garmentq templates list --parts
      garmentq templates export tshirt+neckline=v -o vneck.json
    """
    from dataclasses import asdict, astuple

    from .terminal import print_json, print_table

    if parts:
        choices = _list_parts()
        if as_json:
            for part, words in choices.items():
                print_json({"part": part, "choices": words})
        else:
            print_table(["part", "choices"], [[part, ", ".join(words)] for part, words in choices.items()])
        return
    found = _open(home).list_templates()
    if as_json:
        for template in found:
            print_json(asdict(template))
    else:
        print_table(["name", "category", "source", ""], [astuple(template) for template in found])


@command.command("show")
@click.argument("name")
@home_option
@json_option
def show_command(name: str, home: Path | None, as_json: bool) -> None:
    """Show the panels of a template.

    \b
    Example:
      garmentq templates show skirt
    """
    from ..core.garment.curves import panel_area
    from .terminal import print_json, print_table

    pattern = _load(name, home)
    panels = [
        {"panel": p.name, "label": p.label, "edges": len(p.edges), "area_cm2": 1e4 * float(panel_area(p))}
        for p in pattern.panels
    ]
    if as_json:
        print_json({"name": name, "category": pattern.category, "seams": len(pattern.seams), "panels": panels})
        return
    title = f"{name}: {pattern.category or 'any category'}, {len(pattern.seams)} seams"
    print_table(["panel", "label", "edges", "area cm2"], [list(panel.values()) for panel in panels], title)


@command.command("import")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--name", required=True, help="Name of the template.")
@click.option("--units", type=click.Choice(tuple(UNITS)), help="Unit of the file's numbers, where it claims another.")
@home_option
@json_option
def import_command(file: Path, name: str, units: str | None, home: Path | None, as_json: bool) -> None:
    """Import a GarmentCode or NeuralTailor pattern file as a template.

    \b
    Example:
      garmentq templates import jacket.json --name jacket
    """
    from dataclasses import asdict

    from .terminal import print_json, print_note

    if units is None:
        found = _open(home).import_template(name, file)
    else:
        with TemporaryDirectory() as folder:
            found = _open(home).import_template(name, _write_with_units(file, units, Path(folder)))
    if as_json:
        print_json(asdict(found))
    else:
        print_note(f"imported '{found.name}': {found.panels} panels, {found.seams} seams")


@command.command("delete")
@click.argument("name")
@home_option
def delete_command(name: str, home: Path | None) -> None:
    """Delete an imported template; jobs that use it keep its file.

    \b
    Example:
      garmentq templates delete jacket
    """
    from .terminal import print_note

    _open(home).delete_template(name)
    print_note(f"template '{name}' is deleted")


@command.command("export")
@click.argument("name")
@click.option("-o", "--out", type=NewFile(), required=True, help="File to write.")
@home_option
def export_command(name: str, out: Path, home: Path | None) -> None:
    """Write a template as a GarmentCode pattern file.

    \b
    Example:
      garmentq templates export skirt -o skirt.json
    """
    from ..core.garment.garmentcode_writer import save_pattern

    pattern = _load(name, home)
    with writing(out):
        save_pattern(pattern, out)
    click.echo(str(out))


def _write_with_units(file: Path, units: str, folder: Path) -> Path:
    """Write a pattern file with another unit into a folder, under its name, and return the copy."""
    from ..core.garment.garmentcode import parse_document, read_bytes
    from ..core.garment.pattern_units import set_units

    document = set_units(parse_document(read_bytes(file)), units)
    copy = folder / file.name
    copy.write_text(json.dumps(document), encoding="utf-8")
    return copy


def _list_parts() -> dict[str, list[str]]:
    """Return the choices of every part."""
    from ..core.garment.parts.cut import PARTS

    return {part: [str(choice) for choice in choices] for part, choices in PARTS.items()}


def _open(home: Path | None) -> Backend:
    from ..service.backend import open_backend
    from ..service.settings import read_settings

    return open_backend(read_settings(home=home))


def _load(name: str, home: Path | None) -> Pattern:
    """Load an imported or a shipped template."""
    from ..core.garment.garmentcode import read_pattern

    return read_pattern(_open(home).read_template(name), name=name)
