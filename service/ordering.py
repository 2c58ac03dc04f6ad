"""From files and settings to a checked order."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.body import is_builtin
from ..core.errors import BadInput
from ..core.settings import RecoverySettings, SettingsBad
from .services import Services
from .settings import ServiceSettings
from .submission import BodyUnreadable, Order
from .templates import find_template

if TYPE_CHECKING:
    from ..core.scan import Selection


class FileUnreadable(BadInput):
    """A file cannot be opened; check its path and its rights."""

    code = "input.unreadable"


def check_order(services: Services, order: Order, template: str | None = None) -> Order:
    """Check files and names before anything is queued, and find the file of an imported template.

    Args:
        services: The home whose checker and templates count.
        order: What is wanted; a template in it is a file.
        template: Name of a shipped or imported template, or None. Never a path.

    Raises:
        GarmentqError: with the code of what cannot be used.
    """
    checked = check_files(services.settings, order)
    if order.template is not None or template is None:
        return checked
    file = find_template(services, template)
    return replace(checked, template=file, settings=replace(checked.settings, template=template))


def check_files(settings: ServiceSettings, order: Order) -> Order:
    """Check all of an order but the name of its template.

    Raises:
        GarmentqError: with the code of what cannot be used.
    """
    from ..core.recovery import make_selection

    _check_names(order.settings)
    selection = make_selection(order.labels, order.settings)
    body = None if order.body is None and selection is not None else _check_body(order.body)
    _check_meshes(settings, replace(order, body=body), selection)
    if order.template is not None:
        from ..core.pattern import load_pattern

        load_pattern(order.template)
    return replace(order, body=body)


def _check_meshes(settings: ServiceSettings, order: Order, selection: Selection | None) -> None:
    check, body, chosen = settings.find("checker"), order.body, order.settings
    part = {} if selection is None else {"selection": selection}
    try:
        check(order.scan, body if isinstance(body, Path) else None, units=chosen.units, up=chosen.up, **part)
    except OSError as error:
        raise FileUnreadable(f"'{error.filename}' cannot be read: {error.strerror}.") from error


def _check_names(chosen: RecoverySettings) -> None:
    from ..core.simulate import get_fabric

    if chosen.garment is not None:
        from ..core.segment import CATEGORIES

        if chosen.garment not in CATEGORIES:
            raise SettingsBad(f"garment '{chosen.garment}' is not one of {', '.join(CATEGORIES)}.")
    get_fabric(chosen.fabric)


def _check_body(body: Path | str | None) -> Path | str:
    from ..core.body import BodyMissing, parse_spec

    if body is None:
        raise BodyMissing()
    if is_builtin(body):
        parse_spec(body)  # whoever can be described can be made; making takes 0.3 s
        return body
    path = Path(body)
    if not path.is_file():
        raise BodyUnreadable(f"there is no body file '{body}'; give a mesh, or --body builtin:female,height=1.70.")
    return path
