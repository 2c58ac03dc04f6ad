"""How long a test waits for what is sure to come."""

from __future__ import annotations

WAIT_SECONDS = 600.0
"""A deadline that only a hang reaches, however loaded the machine is."""
