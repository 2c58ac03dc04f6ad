"""Inputs of `submit` beside single files: folders of scans, and tables with a row for each scan."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from ..core.run.errors import BadInput
from .options import OrderOptions

SINGLE_OPTIONS = (
    "body",
    "labels",
    "labels_key",
    "wearing",
    "keep_colour",
    "units",
    "up",
    "name",
    "subject",
    "free",
    "quality",
    "method",
    "preset",
    "redrape",
)
"""Columns for an option that is given once."""

NUMBER_OPTIONS = ("height",)
"""Columns for an option that is a number."""

REPEATED_OPTIONS = {"keep": "keep", "cloth": "cloth", "template": "template", "garment": "garment", "fabric": "fabric",
            "lock": "lock", "mark": "mark", "tags": "tags"}  # fmt: skip
"""Columns for an option that may be repeated, separated by `;`."""

PATH_COLUMNS = ("body", "labels")
"""Columns with a file's path, relative to the table's folder."""

MAX_TABLE_ROWS = 100_000
"""Largest number of rows of a table of orders, which is read completely."""


class TableBad(BadInput):
    """A table needs a header with the column `scan`; its other columns are named as the options of `submit`."""

    code = "submit.table_bad"


class FolderEmpty(BadInput):
    """The folder has no file that is read as a scan; name another one, or the files themselves."""

    code = "submit.folder_empty"


def find_scans(paths: Sequence[Path], options: OrderOptions) -> Iterator[tuple[Path, OrderOptions]]:
    """Yield each scan with its options: files as they are, folders by name, tables (.csv) row by row.

    An empty cell stands for the option of the command.

    Raises:
        TableBad, FolderEmpty: if one cannot be used.
    """
    for path in paths:
        if path.is_dir():
            for file in _list_folder(path):
                yield file, options
        elif path.suffix.lower() == ".csv":
            yield from _read_table(path, options)
        else:
            yield path, options


def _list_folder(folder: Path) -> list[Path]:
    from ..core.scan.header import check_extension

    found = []
    for path in sorted(folder.iterdir()):
        try:
            check_extension(path)
        except BadInput:
            continue
        found += [path] if path.is_file() else []
    if not found:
        raise FolderEmpty(f"{folder} contains no scan; name another folder, or the files themselves.")
    return found


def _read_table(path: Path, options: OrderOptions) -> Iterator[tuple[Path, OrderOptions]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.DictReader(stream)
            columns = reader.fieldnames or []
            unknown = sorted(set(columns) - {"scan", "as", *SINGLE_OPTIONS, *NUMBER_OPTIONS, *REPEATED_OPTIONS})
            if "scan" not in columns or unknown:
                wrong = f"there is no column '{unknown[0]}'" if unknown else "the column 'scan' is missing"
                raise TableBad(f"{path.name}: {wrong}; columns are named as the options of `garmentq submit`.")
            rows = [row for row, _ in zip(reader, range(MAX_TABLE_ROWS), strict=False)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise TableBad(f"{path.name} cannot be read as a table: {type(error).__name__}.") from error
    for number, row in enumerate(rows, 2):
        if not row["scan"] or None in row:
            raise TableBad(f"{path.name}, line {number}: a row needs a scan, and no more cells than the header.")
        yield path.parent / row["scan"], _apply(row, options, path.parent)


def _apply(row: dict[str, str | None], options: OrderOptions, folder: Path) -> OrderOptions:
    changes: dict[str, object] = {}
    for name in SINGLE_OPTIONS:
        if text := row.get(name):
            is_file = name in PATH_COLUMNS and not text.startswith("builtin:")
            place = folder / text if is_file else text
            changes[name] = str(place) if name == "body" else place
    for name in NUMBER_OPTIONS:
        if text := row.get(name):
            try:
                changes[name] = float(text)
            except ValueError as error:
                raise TableBad(f"'{text[:40]}' in the column '{name}' is no number; correct the table.") from error
    for name, field in REPEATED_OPTIONS.items():
        if text := row.get(name):
            changes[field] = tuple(part.strip() for part in text.split(";") if part.strip())
    if text := row.get("as"):
        changes["given_as"] = text
    return replace(options, **changes)  # type: ignore[arg-type]
