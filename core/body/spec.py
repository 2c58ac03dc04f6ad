"""A wearer that is described, not scanned: `builtin:female,height=1.70`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

BUILTIN = "builtin:"
"""How the description of a built-in body begins."""


@dataclass(frozen=True)
class BuiltinWearer:
    """Describe a built-in body; `parse_spec` says what a description may hold.

    Attributes:
        spec: The description, which begins with `BUILTIN`.
    """

    spec: str

    def __post_init__(self) -> None:
        """Refuse a text that is no description: a file's path, say.

        Raises:
            ValueError: where it does not begin as one.
        """
        if not is_builtin(self.spec):
            raise ValueError(f"'{self.spec[:40]}' does not begin with {BUILTIN}")

    def __str__(self) -> str:
        """Return the description."""
        return self.spec


Wearer = Path | BuiltinWearer
"""Who wears a garment, where it is not in the garment's own file: a body's file or a built-in body."""


def is_builtin(text: str | None) -> bool:
    """Check whether a text that was typed or sent describes a built-in body."""
    return text is not None and text.startswith(BUILTIN)


def read_wearer(text: str | None) -> Wearer | None:
    """Return the wearer that a text names: a built-in body by its description, or else a body's file."""
    if text is None:
        return None
    return BuiltinWearer(text) if is_builtin(text) else Path(text)
