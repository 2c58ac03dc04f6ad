"""`garmentq templates`: the shipped base patterns, and those that were imported."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .options import home_option, json_option

if TYPE_CHECKING:
    from ..core.pattern import Pattern


@click.group("templates")
def command() -> None:
    """List, show, import and export template patterns.

    \b
    Example:
      garmentq templates list
      garmentq templates import jacket.json --name jacket
      garmentq run scan.ply --body body.ply --template jacket
    """


@command.command("list")
@home_option
@json_option
def list_command(home: Path | None, as_json: bool) -> None:
    """List the templates.

    \b
    Example:
      garmentq templates list
    """
    from ..service.anywhere import list_templates
    from .terminal import print_json, print_table

    rows = list_templates(_open(home)[0])
    if as_json:
        for row in rows:
            print_json(row)
    else:
        print_table(["name", "category", "source", ""], [list(row.values()) for row in rows])


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
    from ..core.pattern import panel_area
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
@click.option("--name", required=True, help="What the template will be called.")
@home_option
@json_option
def import_command(file: Path, name: str, home: Path | None, as_json: bool) -> None:
    """Import a GarmentCode or NeuralTailor pattern file as a template.

    \b
    Example:
      garmentq templates import jacket.json --name jacket
    """
    from ..core.pattern import list_templates, load_pattern
    from ..service.anywhere import import_template
    from ..service.templates import TemplateNameBad
    from .terminal import note, print_json

    pattern = load_pattern(file)
    if name in [info.name for info in list_templates()]:
        raise TemplateNameBad(f"'{name}' is the name of a shipped template; choose another.")
    database, store = _open(home)
    import_template(database, store, name, file, pattern.category, len(pattern.panels))
    found = {"name": name, "panels": len(pattern.panels), "seams": len(pattern.seams), "category": pattern.category}
    if as_json:
        print_json(found)
    else:
        note(f"imported '{name}': {len(pattern.panels)} panels, {len(pattern.seams)} seams")


@command.command("export")
@click.argument("name")
@click.option("-o", "--out", type=click.Path(dir_okay=False, path_type=Path), required=True, help="File to write.")
@home_option
def export_command(name: str, out: Path, home: Path | None) -> None:
    """Write a template as a GarmentCode pattern file.

    \b
    Example:
      garmentq templates export skirt -o skirt.json
    """
    from ..core.pattern import save_pattern

    save_pattern(_load(name, home), out)
    click.echo(str(out))


def _open(home: Path | None) -> tuple[Any, Any]:
    from ..service.anywhere import open_database
    from ..service.settings import read_settings
    from ..service.stores import open_store

    settings = read_settings(home=home)
    return open_database(settings), open_store(settings)


def _load(name: str, home: Path | None) -> Pattern:
    """Load an imported or a shipped template."""
    from ..core.pattern import load_template, read_pattern
    from ..service.anywhere import read_template

    content = read_template(*_open(home), name)
    return load_template(name) if content is None else read_pattern(content, name=name)
