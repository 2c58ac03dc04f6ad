"""Choices of parts as words: read from a text, and those by which two cuts differ."""

from __future__ import annotations

from dataclasses import fields

from .cut import PARTS, Cut, PartUnknown


def parse_parts(text: str) -> dict[str, str]:
    """Read choices of parts, `neckline=v,sleeve=long`, without checking that they exist.

    Raises:
        PartUnknown: where one has no `=`, or a part is named twice.
    """
    found: dict[str, str] = {}
    for word in filter(None, (word.strip() for word in text.split(","))):
        part, sign, choice = (piece.strip() for piece in word.partition("="))
        if not sign or part in found:
            raise PartUnknown(f"'{word[:60]}' is not PART=CHOICE, each part once, as in neckline=v.")
        found[part] = choice
    return found


def differing_parts(cut: Cut, other: Cut) -> dict[str, str]:
    """Return the choices that turn a cut into another one, except for measures."""
    names = (field.name for field in fields(Cut) if field.name in PARTS)
    return {name: str(getattr(other, name)) for name in names if getattr(other, name) != getattr(cut, name)}
