"""A wearer by description, not by scan: `builtin:female,height=1.70`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

BUILTIN = "builtin:"
"""Prefix of the description of a built-in body."""

MODEL_FILE_SUFFIXES = (".npz", ".json")
"""Ends of the names of body models' files; all other files of bodies are meshes."""


@dataclass(frozen=True)
class BuiltinWearer:
    """Describe a built-in body by its description, which begins with `BUILTIN`; `parse_spec` has the grammar."""

    spec: str

    def __post_init__(self) -> None:
        """Refuse a text that is not a description, such as a file's path.

        Raises:
            ValueError: where it does not begin with `BUILTIN`.
        """
        if not is_builtin(self.spec):
            raise ValueError(f"'{self.spec[:40]}' does not begin with {BUILTIN}")

    def __str__(self) -> str:
        """Return the description."""
        return self.spec


Wearer = Path | BuiltinWearer
"""The wearer of a garment whose file has none: a body's file or a built-in body."""


def is_builtin(text: str | None) -> bool:
    """Check whether a text describes a built-in body."""
    return text is not None and text.startswith(BUILTIN)


def is_body_model(body: object) -> bool:
    """Check by the name's ending whether a body is the file of a body model, and not a mesh."""
    return str(body).lower().endswith(MODEL_FILE_SUFFIXES)


def read_wearer(text: str | None) -> Wearer | None:
    """Parse a wearer: a built-in body by its description, else a body's file."""
    if text is None:
        return None
    return BuiltinWearer(text) if is_builtin(text) else Path(text)
