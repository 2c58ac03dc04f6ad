"""From typed options to orders."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from ..core.body import is_builtin
from ..core.settings import RecoverySettings
from ..service.backend import Backend
from ..service.submission import Order
from .options import OrderOptions


def make_order(backend: Backend, scan: Path, options: OrderOptions) -> Order:
    """Check the files and names that were typed, before anything is queued.

    Args:
        backend: Where the job will be, and imported templates are.
        scan: The garment's file.
        options: What was typed; of several `--keep` the first.

    Raises:
        GarmentqError: with the code of what cannot be used.
    """
    template = options.template
    file = Path(template) if template is not None and Path(template).is_file() else None
    body = options.body if options.body is None or is_builtin(options.body) else Path(options.body)
    order = Order(
        scan,
        body,
        file,
        make_settings(options),
        force=options.force,
        labels=options.labels,
        name=options.name,
        tags=options.tags,
    )
    return backend.check_order(order, None if file is not None else template)


def make_settings(options: OrderOptions) -> RecoverySettings:
    """Return the settings that were typed, but the template.

    Raises:
        SettingsBad: where a value is outside its list or range.
    """
    return RecoverySettings(
        method=options.method,
        preset=options.preset,
        garment=options.garment,
        fabric=options.fabric,
        lock=",".join(options.lock) or None,
        free=options.free,
        units=options.units,
        up=options.up,
        vertex_count=options.vertices,
        seed=options.seed,
        keep=options.keep[0] if options.keep else None,
        labels_key=options.labels_key,
        keep_colour=options.keep_colour,
        colour_tolerance=options.colour_tolerance,
        cloth=",".join(options.cloth) or None,
    )


def split_garments(options: OrderOptions) -> Iterator[OrderOptions]:
    """Yield the options of each garment of a scan: one for each `--keep`, the others being clothes too."""
    if not options.keep:
        yield options
    for keep in options.keep:
        others = tuple(other for other in options.keep if other != keep)
        yield replace(options, keep=(keep,), cloth=(*options.cloth, *others))
