"""Log files of a home's processes: one that has grown large is copied and emptied, as logrotate does.

Several processes append to one file, which stays open, so that it cannot be renamed; a line that is written between the
copy and the emptying is lost.
"""

from __future__ import annotations

import logging
import os
import shutil
from contextlib import suppress
from pathlib import Path

from ..service.private import PRIVATE_FILE_MODE
from ..service.settings import ServiceSettings

log = logging.getLogger(__name__)

LOG_NAMES = ("worker.log", "broker.log", "courier.log")

MAX_LOG_SIZE = 10 << 20
"""Size from which a log is begun anew [bytes]; a job writes about ten lines."""

KEPT_LOGS = 3
"""Number of earlier logs that are kept, `worker.log.1` the latest."""


def rotate_logs(settings: ServiceSettings) -> int:
    """Begin each large log of a home anew; return how many were."""
    return sum(_rotate(settings.home / name) for name in LOG_NAMES)


def _rotate(path: Path) -> bool:
    try:
        if path.stat().st_size < MAX_LOG_SIZE:
            return False
        for number in range(KEPT_LOGS, 1, -1):
            with suppress(FileNotFoundError):
                os.replace(f"{path}.{number - 1}", f"{path}.{number}")
        shutil.copyfile(path, f"{path}.1")
        os.chmod(f"{path}.1", PRIVATE_FILE_MODE)
        os.truncate(path, 0)
    except FileNotFoundError:
        return False
    except OSError as error:  # a full disk: what was copied would take the room again
        log.warning("the log %s cannot be copied: %s", path, error.strerror)
        with suppress(OSError):
            os.truncate(path, 0)
    return True
