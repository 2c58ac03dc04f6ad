"""From typed options to a checked order."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from ..core.body import is_builtin
from ..core.settings import RecoverySettings
from ..service.anywhere import Place
from ..service.database import Database
from ..service.ordering import FileUnreadable, check_order
from ..service.settings import ServiceSettings
from ..service.stores import open_store
from ..service.submission import Order

__all__ = ["FileUnreadable", "make_order", "split_garments", "typed_order"]


def make_order(settings: ServiceSettings, database: Place, scan: Path, options: dict[str, Any]) -> Order:
    """Check the files and names that were typed, before anything is queued.

    Args:
        settings: Where the checker is named.
        database: Where imported templates are; or a client of a service that has them.
        scan: The garment's file.
        options: What `order_options` collected; of several `--keep` the first.

    Raises:
        GarmentqError: with the code of what cannot be used.
    """
    order, template = typed_order(scan, options)
    if isinstance(database, Database):
        return check_order(settings, database, open_store(settings), order, template)
    checked = check_order(settings, database, open_store(settings), order, None)  # the service knows its templates
    return replace(checked, settings=replace(checked.settings, template=template))


def typed_order(scan: Path, options: dict[str, Any]) -> tuple[Order, str | None]:
    """Give the order as it was typed, unchecked, and the name of its template unless that is a file.

    Raises:
        SettingsBad: where a value is outside its list or range.
    """
    chosen = RecoverySettings(
        method=options["method"],
        preset=options["preset"],
        garment=options["garment"],
        fabric=options["fabric"],
        lock=",".join(options.get("lock", ())) or None,
        free=options.get("free"),
        units=options["units"],
        up=options["up"],
        vertex_count=options["vertices"],
        seed=options["seed"],
        keep=(options["keep"] or (None,))[0],
        labels_key=options["labels_key"],
        keep_colour=options["keep_colour"],
        colour_tolerance=options["colour_tolerance"],
        cloth=",".join(options.get("cloth", ())) or None,
    )
    body: Path | str | None = options["body"]
    if body is not None and not is_builtin(body):
        body = Path(body)
    template = options["template"]
    file = Path(template) if template is not None and Path(template).is_file() else None
    order = Order(
        scan, body, file, chosen, force=options["force"], labels=options["labels"], queue=options.get("queue", "cpu")
    )
    return order, None if file is not None else template


def split_garments(options: dict[str, Any]) -> list[dict[str, Any]]:
    """Give the options of each garment of a scan: one for each `--keep`, the others being clothes too."""
    keeps, worn = options["keep"], options.get("cloth", ())
    return [
        options | {"keep": (keep,), "cloth": (*worn, *(other for other in keeps if other != keep))} for keep in keeps
    ] or [options]
