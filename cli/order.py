"""Conversion of command-line options to orders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from ..core.body.spec import read_wearer
from ..core.people.part import GARMENTS
from ..core.recover.settings import QUALITIES, RecoverySettings, SettingsBad, complete_by_quality
from ..service.backend import Backend
from ..service.order import Order, PartOrder, is_person
from ..service.terms import JobTerms
from .options import OrderOptions

WORDS = tuple(part.word for part in GARMENTS)
"""The garments of a person, as they precede a choice."""


def make_order(backend: Backend, scan: Path, options: OrderOptions) -> Order:
    """Check the files and names in the options, before anything is queued.

    Args:
        backend: The job's backend, which has the imported templates.
        scan: The garment's file.
        options: The options; of several `--keep` the first is used.

    Raises:
        GarmentqError: with the code of what cannot be used.
    """
    template, by_part = split_choice("template", options.template)
    file = find_file(template)
    order = Order(
        scan,
        read_wearer(options.body),
        file,
        make_settings(options),
        labels=options.labels,
        given_as=options.given_as,
        wearing=options.wearing,
        marks=options.mark,
        choices=make_choices(options, by_part),
        terms=JobTerms(options.name, options.tags, force=options.force, subject=options.subject),
    )
    return backend.check_order(order, None if file is not None else template)


def find_file(template: str | None) -> Path | None:
    """Return the pattern file, or None if the text is a template's name."""
    return Path(template) if template is not None and Path(template).is_file() else None


def split_part(text: str) -> tuple[str, str]:
    """Return the part in front of a value, or an empty text, and the rest: `upper:denim`."""
    word, _, rest = text.partition(":")
    return (word, rest) if rest and word in WORDS else ("", text)


def split_choice(name: str, typed: Sequence[str]) -> tuple[str | None, dict[str, str]]:
    """Return the value of an option without a part, and its values by part.

    Raises:
        SettingsBad: if it is given twice for the same part.
    """
    found: dict[str, str] = {}
    for text in typed:
        part, value = split_part(text)
        if part in found:
            raise SettingsBad(f"--{name} is given twice{f' for {part}' if part else ''}; give it once, or once a part.")
        found[part] = value
    return found.pop("", None), found


def make_choices(options: OrderOptions, templates: Mapping[str, str]) -> dict[str, PartOrder]:
    """Return the options for single garments, by their words.

    Args:
        options: The options.
        templates: Pattern file or template's name of each part that has one.
    """
    garments, fabrics = (split_choice(name, getattr(options, name))[1] for name in ("garment", "fabric"))
    locks, parts = split_lists(options.lock), split_lists(options.part)
    found = {}
    for word in WORDS:
        if word in {*templates, *garments, *fabrics, *locks, *parts}:
            template = templates.get(word)
            file = find_file(template)
            name = None if file is not None else template
            choice = (garments.get(word), fabrics.get(word), locks.get(word), parts.get(word))
            found[word] = PartOrder(file, name, *choice)
    return found


def split_lists(typed: Sequence[str]) -> dict[str, str]:
    """Return the values of a repeated option by part, joined by commas; those for all garments have an empty part."""
    found: dict[str, list[str]] = {}
    for text in typed:
        part, value = split_part(text)
        found.setdefault(part, []).append(value)
    return {part: ",".join(values) for part, values in found.items()}


def describe_choice(order: Order) -> str:
    """Return how a scan is interpreted, as text for users."""
    if is_person(order):
        said = "" if order.given_as else "; --as garment overrides this"
        return f"treated as a whole person, whose garments are detected{said}"
    chosen = order.settings
    if chosen.keep is not None or chosen.keep_colour is not None:
        return "treated as a person of whom one garment is recovered"
    if order.given_as:
        return "treated as a garment"
    if order.labels is not None:
        return "treated as a person with a label file; if it has names, all garments in it are recovered"
    return "treated as a garment on its body, unless it shows head, hands or feet; --as person overrides this"


def describe_overrides(options: OrderOptions) -> str:
    """Return which options override the chosen quality, as text for users; empty if none does."""
    overrides = {"method": ("--method", options.method), "vertex_count": ("--vertices", options.vertices)}
    own = QUALITIES.get(options.quality or "", {})
    return "".join(
        f"; {option} {value} overrides --quality {options.quality}"
        for name, (option, value) in overrides.items()
        if value is not None and own.get(name, value) != value
    )


def make_settings(options: OrderOptions) -> RecoverySettings:
    """Return the settings in the options, without the template.

    Raises:
        SettingsBad: if a value is outside its list or range, or is given twice.
    """
    overrides = {"method": options.method, "vertex_count": options.vertices}
    return RecoverySettings(
        **complete_by_quality(options.quality, {name: value for name, value in overrides.items() if value is not None}),
        preset=options.preset,
        garment=split_choice("garment", options.garment)[0],
        fabric=split_choice("fabric", options.fabric)[0],
        lock=split_lists(options.lock).get(""),
        free=options.free,
        units=options.units,
        up=options.up,
        height=options.height,
        seed=options.seed,
        keep=options.keep[0] if options.keep else None,
        labels_key=options.labels_key,
        keep_colour=options.keep_colour,
        colour_tolerance=options.colour_tolerance,
        cloth=",".join(options.cloth) or None,
        parts=split_lists(options.part).get(""),
        keep_cut=options.keep_cut or None,
        redrape=options.redrape,
    )


def split_garments(options: OrderOptions) -> Iterator[OrderOptions]:
    """Yield the options of each garment of a scan: one for each `--keep`, with the other labels as cloth."""
    if not options.keep:
        yield options
    for keep in options.keep:
        others = tuple(other for other in options.keep if other != keep)
        yield replace(options, keep=(keep,), cloth=(*options.cloth, *others))
