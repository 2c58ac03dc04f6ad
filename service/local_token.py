"""The token of a service without keys: only a user who can read the home is its local user."""

from __future__ import annotations

import os
import secrets
from pathlib import Path
from urllib.parse import urlsplit

from .private import make_private

NAME = "api.token"


def read_local_token(home: Path) -> str:
    """Return the home's token, or an empty text if it has none that this user can read."""
    try:
        return (home / NAME).read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError):
        return ""


def find_local_token(url: str, home: Path) -> str:
    """Return the home's token for a service on this machine, and an empty text for any other."""
    host = urlsplit(url).hostname or ""
    return read_local_token(home) if host in ("localhost", "127.0.0.1", "::1") else ""


def make_local_token(home: Path) -> str:
    """Return the home's token; create it if there is none, in a file that only its owner can read."""
    if known := read_local_token(home):
        return known
    make_private(home)
    try:
        descriptor = os.open(home / NAME, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        return read_local_token(home)  # another process has created it
    with os.fdopen(descriptor, "w", encoding="ascii") as out:
        out.write(token := "gq_local_" + secrets.token_hex(32))
    return token
