"""Take the fixtures of the stand-in home."""

from __future__ import annotations

import sys
from pathlib import Path

from garmentq_home import (  # noqa: F401
    blank_database,
    cli,
    database,
    database_kind,
    database_url,
    postgres,
    queue_job,
    settings,
    store,
)

sys.path.insert(0, str(Path(__file__).parents[1] / "api"))
