"""Templates: the shipped ones, and those that a user imported under a name, each stored as the given file."""

from __future__ import annotations

import json
import re
from pathlib import Path

from sqlalchemy import select

from ..core.run.errors import BadInput
from ..core.run.sandbox import Bounds, IsStopped, call_limited, never_stopped
from .catalogue import ImportedTemplate, Template
from .database import Database, clock, skip_damaged_rows
from .models import TemplateRow
from .services import Services
from .store import Store

BOUNDS = Bounds(memory_bytes=1024**3, cpu_seconds=20, wall_seconds=60.0)
"""Limits of reading a pattern file: it takes 0.5 s, nearly all of it to start the process."""
NAME = re.compile(r"[a-z0-9][a-z0-9_.-]{0,63}", re.ASCII)


class TemplateNameBad(BadInput):
    """A template's name consists of lower-case letters, digits, '_', '.' and '-', at most 64 of them."""

    code = "template.name_bad"


class TemplateShipped(BadInput):
    """A shipped template cannot be deleted."""

    code = "template.shipped"


def import_template(
    services: Services, name: str, path: Path, is_stopped: IsStopped = never_stopped
) -> ImportedTemplate:
    """Check a GarmentCode or NeuralTailor pattern file and store it; an imported template of the same name is replaced.

    Raises:
        TemplateNameBad: if the name is invalid, or a shipped template's.
        PatternBad: if the file cannot be read.
    """
    from ..core.garment.templates import list_templates

    arguments = {"source": str(path.absolute())}
    found = call_limited("garmentq.service.inspect_reading:check_pattern", arguments, BOUNDS, is_stopped).result
    if name in [info.name for info in list_templates()]:
        raise TemplateNameBad(f"'{name}' is the name of a shipped template; choose another.")
    keep_template(services.database, services.store, name, path, found["category"], found["panels"])
    return ImportedTemplate(name, **found)


def keep_template(database: Database, store: Store, name: str, path: Path, category: str, panels: int) -> None:
    """Store a checked pattern file under a name; an imported template of the same name is replaced.

    Raises:
        TemplateNameBad: if the name is invalid.
    """
    if not NAME.fullmatch(name):
        raise TemplateNameBad()
    kept = store.put(path)
    with database.write() as session:
        session.merge(TemplateRow(name=name, sha256=kept.sha256, category=category, panels=panels, created=clock()))


def delete_template(database: Database, name: str) -> Template:
    """Delete an imported template and return it; jobs that use it keep its file.

    Raises:
        TemplateUnknown, TemplateShipped: if there is none of that name, or it is a shipped one.
    """
    from ..core.garment.templates import TemplateUnknown, list_templates

    with database.write() as session:
        row = session.get(TemplateRow, name)
        if row is not None:
            session.delete(row)
            return _show_imported(row)
    if name in [info.name for info in list_templates()]:
        raise TemplateShipped(f"'{name}' is a shipped template, which cannot be deleted.")
    raise TemplateUnknown(f"there is no template '{name[:80]}'; `garmentq templates list` shows them.")


def find_template(services: Services, name: str) -> Path | None:
    """Return the file of an imported template; None for a shipped one, which needs no file.

    Raises:
        TemplateUnknown: if there is neither.
    """
    from ..core.garment.templates import load_template

    kept = _find_imported(services.database, name)
    if kept is None:
        load_template(name)
        return None
    return services.store.path(kept.sha256)


def read_template(services: Services, name: str) -> bytes:
    """Return the pattern file of a template.

    Raises:
        TemplateUnknown: if there is none of that name.
    """
    from ..core.garment.garmentcode_writer import write_pattern
    from ..core.garment.templates import load_template

    kept = _find_imported(services.database, name)
    if kept is not None:
        return services.store.get_bytes(kept.sha256)
    return json.dumps(write_pattern(load_template(name)), indent=1).encode()


@skip_damaged_rows
def list_templates(database: Database) -> list[Template]:
    """Return shipped and imported templates, each kind by name."""
    from ..core.garment import templates

    found = [Template(info.name, info.category, "shipped", info.title) for info in templates.list_templates()]
    with database.read() as session:
        rows = session.scalars(select(TemplateRow).order_by(TemplateRow.name)).all()
    return found + [_show_imported(row) for row in rows]


def _show_imported(row: TemplateRow) -> Template:
    return Template(row.name, row.category, "imported", f"{row.panels} panels")


def _find_imported(database: Database, name: str) -> TemplateRow | None:
    with database.read() as session:
        return session.get(TemplateRow, name)
