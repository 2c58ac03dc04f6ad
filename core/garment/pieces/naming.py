"""Names of pieces that every cutting program accepts."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection

from ..panel_parts import find_arm_panels, find_side
from ..pattern import Pattern
from .joining import HALF_PANEL_WORDS

MAX_PIECE_NAME_LENGTH = 20
"""Largest length of a piece's name [characters]: that of Gerber's reader."""

SIDES = ("left", "right", "l", "r")


def name_pieces(pattern: Pattern, members: list[tuple[tuple[str, ...], bool]]) -> list[str]:
    """Return a unique name of each piece: upper case letters, digits, `_` and `-`, at most 20. Where the panels' names
    have no Latin letters, or say no more than the side, a piece is called by its place on the wearer.

    Args:
        pattern: The pattern.
        members: The names of the panels in each piece, and whether it is for both sides of the wearer.
    """
    names: list[str] = []
    for panels, both in members:
        base = _to_ascii_name(_common(panels, both))[:MAX_PIECE_NAME_LENGTH]
        if not re.search("[A-Z]", base) or (both and base.lower() in SIDES):
            base = _describe_place(pattern, panels)
        names.append(number_name(base, names))
    return names


def extend_name(name: str, words: str) -> str:
    """Return a piece's name with further words; where that is too long, without the last words of the name."""
    own = name.split("_")
    while len(own) > 1 and len("_".join((*own, words))) > MAX_PIECE_NAME_LENGTH:
        own.pop()
    return f"{'_'.join(own)[: MAX_PIECE_NAME_LENGTH - len(words) - 1]}_{words}"


def say_name(name: str) -> str:
    """Return a piece's name as it is printed, its words apart: `COLLAR FALL`."""
    return name.replace("_", " ")


def number_name(name: str, taken: Collection[str]) -> str:
    """Return a name that is not taken: with a number where it is."""
    found, number = name, 2
    while found in taken:
        tail = f"_{number}"
        found, number = name[: MAX_PIECE_NAME_LENGTH - len(tail)] + tail, number + 1
    return found


def _describe_place(pattern: Pattern, panels: tuple[str, ...]) -> str:
    """Return a name of panels by their place: a sleeve, or a cuff beyond it; else the wearer's front, back or side."""
    depth = min(find_arm_panels(pattern).get(name, 0) for name in panels)
    if depth:
        return "SLEEVE" if depth == 1 else "CUFF"
    return "_".join(dict.fromkeys(find_side(pattern.panel(name)).upper() for name in panels))


def _common(panels: tuple[str, ...], both: bool) -> str:
    """Return the common part of panels' names, without the side of the wearer where the piece is for both."""
    words = [[word for word in re.split(r"[\W_]+", panel) if word] for panel in panels]
    shared = [word for word in words[0] if all(word in other for other in words)]
    if both:
        shared = [word for word in shared if word.lower() not in SIDES]
    if not shared or all(word.lower() in SIDES for word in shared):
        whole = " ".join(panels).lower()
        known = [half for half in HALF_PANEL_WORDS if half in whole] if len(panels) > 1 else []
        shared = known[:1] or ([panels[0]] if not both else words[0][:1])
    return "_".join(shared)


def _to_ascii_name(name: str) -> str:
    """Return a name in upper case ASCII; accents are dropped, other letters become `_`."""
    plain = unicodedata.normalize("NFKD", name)
    plain = "".join(letter for letter in plain if not unicodedata.combining(letter))
    return re.sub(r"[^A-Z0-9-]+", "_", plain.upper()).strip("_")
