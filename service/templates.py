"""Template patterns that a user imported: a name, and the file as it was given."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from sqlalchemy import select

from ..core.errors import BadInput
from .database import Database, clock
from .models import TemplateRow
from .store import Store

NAME = re.compile(r"[a-z0-9][a-z0-9_.-]{0,63}", re.ASCII)


class TemplateNameBad(BadInput):
    """A template's name is made of small letters, digits, '_', '.' and '-', at most 64 of them."""

    code = "template.name_bad"


def keep_template(database: Database, store: Store, name: str, path: Path, category: str, panels: int) -> None:
    """Keep a checked pattern file under a name; one imported before under that name is replaced.

    Raises:
        TemplateNameBad: where the name is none.
    """
    if not NAME.fullmatch(name):
        raise TemplateNameBad()
    kept = store.put(path)
    with database.write() as session:
        session.merge(TemplateRow(name=name, sha256=kept.sha256, category=category, panels=panels, created=clock()))


def find_template(database: Database, name: str) -> TemplateRow | None:
    """Give an imported template by name, or None."""
    with database.read() as session:
        return session.get(TemplateRow, name)


def list_imported(database: Database) -> list[TemplateRow]:
    """Give every imported template by name."""
    with database.read() as session:
        return list(session.scalars(select(TemplateRow).order_by(TemplateRow.name)))


def describe_templates(database: Database) -> list[dict[str, Any]]:
    """Give shipped and imported templates: name, category, source, title."""
    from ..core.pattern import list_templates

    found = [{"name": i.name, "category": i.category, "source": "shipped", "title": i.title} for i in list_templates()]
    for kept in list_imported(database):
        title = f"{kept.panels} panels"
        found.append({"name": kept.name, "category": kept.category, "source": "imported", "title": title})
    return found
