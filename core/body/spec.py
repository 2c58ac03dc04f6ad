"""What tells the text that describes a built-in body from a file's path."""

from __future__ import annotations

from typing import TypeGuard

BUILTIN = "builtin:"
"""How the description of a built-in body begins."""


def is_builtin(body: object) -> TypeGuard[str]:
    """Return True for the description of a built-in body; a path and a missing body are none."""
    return isinstance(body, str) and body.startswith(BUILTIN)
