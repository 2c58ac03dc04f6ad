"""Checks of an order's files and settings before it is queued."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ..core.body.spec import BuiltinWearer, Wearer
from ..core.recover.settings import RecoverySettings, SettingsBad
from ..core.run.errors import BadInput
from .materials import resolve_fabric
from .order import Order, is_person
from .services import Services
from .submission import BodyUnreadable
from .templates import find_template


class FileUnreadable(BadInput):
    """A file cannot be opened; check its path and its permissions."""

    code = "input.unreadable"


def check_order(services: Services, order: Order, template: str | None = None) -> Order:
    """Check names and paths before anything is queued, and find the file of an imported template.

    The contents of the files are checked by the job's first stage.

    Args:
        services: The home with the templates.
        order: The order; a template in it is a file.
        template: Name of a shipped or imported template, or None. Never a path.

    Raises:
        GarmentqError: with the code of what cannot be used.
    """
    checked = _find_fabrics(services, check_order_locally(order))
    choices = {
        word: replace(one, template=find_template(services, one.name)) if one.name and one.template is None else one
        for word, one in checked.choices.items()
    }
    if choices:
        checked = replace(checked, choices=choices)
    if order.template is not None or template is None:
        return checked
    file = find_template(services, template)
    if file is None and checked.settings.parts is not None and not is_person(checked):
        from ..core.garment.templates import find_cut

        parts = checked.settings.chosen_parts
        find_cut(template).choose(parts).check_places(parts)
    return replace(checked, template=file, settings=replace(checked.settings, template=template))


def _find_fabrics(services: Services, order: Order) -> Order:
    """Return an order with the imported fabrics that it names; later changes of these names do not change the job.

    Raises:
        FabricUnknown: if there is none of a name.
    """
    fabric = resolve_fabric(services.database, order.settings.fabric)
    choices = {
        word: one if one.fabric is None else replace(one, fabric=resolve_fabric(services.database, one.fabric))
        for word, one in order.choices.items()
    }
    return replace(order, settings=replace(order.settings, fabric=fabric), choices=choices)


def check_order_locally(order: Order) -> Order:
    """Check an order without its service, and without reading its files.

    Raises:
        GarmentqError: with the code of what cannot be used.
    """
    from ..core.recover.recovery import make_selection
    from ..core.scan.header import check_extension
    from ..core.scan.refusal import FileMissing, LabelsUnreadable

    _check_names(order.settings)
    selection = make_selection(order.labels, order.settings)
    _check_file(order.scan, FileMissing(f"{order.scan} is not a file; check the path."))
    check_extension(order.scan)
    if order.labels is not None:
        missing = LabelsUnreadable(f"there is no label file '{order.labels.name}'; check the path.")
        _check_file(order.labels, missing)
    if order.template is not None:
        _check_file(order.template, FileUnreadable(f"there is no pattern file '{order.template}'; check the path."))
    if is_person(order):
        _check_person(order)
        return order if order.body is None else replace(order, body=_check_body(order.body))
    if order.body is None and selection is not None:
        return order
    return replace(order, body=_check_body(order.body))


def _check_person(order: Order) -> None:
    """Check the options of a person and of single garments."""
    from ..core.people.hints import parse_mark, parse_wearing
    from ..core.people.part import GARMENTS

    if order.wearing is not None:
        parse_wearing(order.wearing)
    for mark in order.marks:
        parse_mark(mark)
    words = [part.word for part in GARMENTS]
    for word, one in order.choices.items():
        if word not in words:
            raise SettingsBad(f"'{word[:40]}' is not a garment; name one of {', '.join(words)}.")
        if one.template is not None:
            _check_file(one.template, FileUnreadable(f"there is no pattern file '{one.template}'; check the path."))
        parts = order.settings.overrule_parts(one.parts)
        _check_names(replace(order.settings, garment=one.garment, lock=one.lock, parts=parts))


def _check_file(path: Path, missing: BadInput) -> None:
    """Check that a file exists and can be opened.

    Raises:
        BadInput: `missing`, if it does not exist.
        FileUnreadable: if it cannot be opened.
    """
    if not path.is_file():
        raise missing
    try:
        path.open("rb").close()
    except OSError as error:
        raise FileUnreadable(f"'{path}' cannot be read: {error.strerror}.") from error


def _check_names(chosen: RecoverySettings) -> None:
    if chosen.garment is not None:
        from ..core.scan.contours.target import CATEGORIES

        if chosen.garment not in CATEGORIES:
            raise SettingsBad(f"garment '{chosen.garment}' is not one of {', '.join(CATEGORIES)}.")


def _check_body(body: Wearer | None) -> Wearer:
    from ..core.body.builtin import BodyMissing, parse_spec

    if body is None:
        raise BodyMissing()
    if isinstance(body, BuiltinWearer):
        parse_spec(body.spec)  # a valid specification is enough; making the body takes 0.3 s
        return body
    missing = f"there is no body file '{body}'; give a mesh, or --body builtin:female,height=1.70."
    _check_file(body, BodyUnreadable(missing))
    return body
