"""From typed options to a checked order."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.errors import BadInput
from ..core.settings import RecoverySettings, SettingsBad
from ..service.database import Database
from ..service.settings import ServiceSettings
from ..service.store import Store
from ..service.submission import BUILTIN, BodyUnreadable, Order
from ..service.templates import find_template

if TYPE_CHECKING:
    from ..core.scan import Selection


class FileUnreadable(BadInput):
    """A file cannot be opened; check its path and its rights."""

    code = "input.unreadable"


def make_order(settings: ServiceSettings, database: Database, scan: Path, options: dict[str, Any]) -> Order:
    """Check the files and names that were typed, before anything is queued.

    Args:
        settings: Where the checker is named.
        database: Where imported templates are.
        scan: The garment's file.
        options: What `order_options` collected; of several `--keep` the first.

    Raises:
        GarmentqError: with the code of what cannot be used.
    """
    from ..core.recovery import make_selection

    chosen = RecoverySettings(
        method=options["method"],
        preset=options["preset"],
        garment=options["garment"],
        fabric=options["fabric"],
        units=options["units"],
        up=options["up"],
        vertex_count=options["vertices"],
        seed=options["seed"],
        keep=(options["keep"] or (None,))[0],
        labels_key=options["labels_key"],
        keep_colour=options["keep_colour"],
        colour_tolerance=options["colour_tolerance"],
    )
    _check_names(chosen)
    selection = make_selection(options["labels"], chosen)
    body = None if options["body"] is None and selection is not None else _find_body(options["body"])
    _check_meshes(settings, scan, body, chosen, selection)
    template, name = _find_template(database, Store(settings.store_path), options["template"])
    chosen = replace(chosen, template=name)
    return Order(scan, body, template, chosen, force=options["force"], labels=options["labels"])


def split_garments(options: dict[str, Any]) -> list[dict[str, Any]]:
    """Give the options of each garment of a scan: one for each `--keep`, or the options as they are."""
    return [options | {"keep": (keep,)} for keep in options["keep"]] or [options]


def _check_meshes(
    settings: ServiceSettings,
    scan: Path,
    body: Path | str | None,
    chosen: RecoverySettings,
    selection: Selection | None,
) -> None:
    check = settings.find("checker")
    part = {} if selection is None else {"selection": selection}
    try:
        check(scan, body if isinstance(body, Path) else None, units=chosen.units, up=chosen.up, **part)
    except OSError as error:
        raise FileUnreadable(f"'{error.filename}' cannot be read: {error.strerror}.") from error


def _check_names(chosen: RecoverySettings) -> None:
    from ..core.segment import CATEGORIES
    from ..core.simulate import get_fabric

    if chosen.garment is not None and chosen.garment not in CATEGORIES:
        raise SettingsBad(f"garment '{chosen.garment}' is not one of {', '.join(CATEGORIES)}.")
    get_fabric(chosen.fabric)


def _find_body(text: str | None) -> Path | str:
    from ..core.body import BodyMissing, builtin_body

    if text is None:
        raise BodyMissing()
    if text.startswith(BUILTIN):
        builtin_body(text)
        return text
    path = Path(text)
    if not path.is_file():
        raise BodyUnreadable(f"there is no body file '{text}'; give a mesh, or --body builtin:female,height=1.70.")
    return path


def _find_template(database: Database, store: Store, text: str | None) -> tuple[Path | None, str | None]:
    """Give a pattern file and a name: a file, an imported template (both), or a shipped one (a name only)."""
    if text is None:
        return None, None
    if Path(text).is_file():
        from ..core.pattern import load_pattern

        load_pattern(Path(text))
        return Path(text), None
    imported = find_template(database, text)
    if imported is not None:
        return store.path(imported.sha256), text
    from ..core.pattern import load_template

    load_template(text)
    return None, text
