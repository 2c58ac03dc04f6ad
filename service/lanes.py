"""The lanes of a queue: what somebody waits for goes before what runs by itself."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from ..core.recover.settings import QUALITIES


class Lane(IntEnum):
    """Lane of a job, by which workers choose first; it is set when the job is created, and stored as its number."""

    INTERACTIVE = 0  # somebody waits for it: an edit, an export, corrected labels; seconds to a minute
    PREVIEW = 1  # a recovery that fits no pattern, and its garments
    BATCH = 2  # every other recovery, its garments and re-drapes, and animations


def choose_lane(settings: Mapping[str, Any]) -> Lane:
    """Return the lane of a recovery with these settings."""
    return Lane.PREVIEW if settings.get("method") == QUALITIES["preview"]["method"] else Lane.BATCH
