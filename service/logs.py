"""The log of a process: plain lines, or one JSON object a line with job, attempt and stage."""

from __future__ import annotations

import json
import logging
import sys
import time
from contextvars import ContextVar
from types import TracebackType

from ..core.run.errors import keep_printable

log = logging.getLogger(__name__)

REQUEST: ContextVar[str] = ContextVar("request", default="")
"""Id of the HTTP request that is being answered, as in its response; empty elsewhere."""

QUIET_LOGGERS = ("alembic", "httpx", "botocore", "boto3", "urllib3")
"""Loggers of packages that report each of their steps as information."""

FIELDS = ("job", "attempt", "stage")
"""Fields that a record may have beside its message; null in a line without a job."""


class JsonLines(logging.Formatter):
    """Write a record as one JSON object on one line; a name with line breaks cannot begin a new line."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line: time in UTC, level, process, message, job, attempt, stage, and the traceback if any."""
        seconds = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created))
        line = {
            "time": f"{seconds}.{int(record.msecs):03d}Z",
            "level": record.levelname.lower(),
            "logger": record.name,
            "process": record.processName,
            "pid": record.process,
            "message": record.getMessage(),
            **{name: getattr(record, name, None) or None for name in FIELDS},
            "request": REQUEST.get() or None,
        }
        if record.exc_info:
            line["traceback"] = self.formatException(record.exc_info)
        return json.dumps(line)


class PlainLines(logging.Formatter):
    """Write a record as plain text; a name can neither begin a new record nor move the cursor."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line; following lines (of a traceback, say) are indented, control characters become `?`."""
        lines = super().format(record).split("\n")
        return "\n    ".join(keep_printable(line.expandtabs()) for line in lines)


def set_up_logs(as_json: bool) -> None:
    """Send this process's log to standard error, with the warnings of Python and, as JSON, the last traceback."""
    handler = logging.StreamHandler(sys.stderr)
    readable = PlainLines("%(asctime)s %(levelname)s %(processName)s %(message)s")
    handler.setFormatter(JsonLines() if as_json else readable)
    logging.basicConfig(handlers=[handler], level=logging.INFO)
    for name in QUIET_LOGGERS:
        logging.getLogger(name).setLevel(logging.WARNING)
    logging.captureWarnings(True)
    if as_json:
        sys.excepthook = _log_exception


def is_log_json() -> bool:
    """Return whether this process logs as JSON, so that every line on standard error is to be an object."""
    return any(isinstance(handler.formatter, JsonLines) for handler in logging.getLogger().handlers)


def _log_exception(kind: type[BaseException], error: BaseException, traceback: TracebackType | None) -> None:
    """Log what ends the process."""
    log.critical("%s ends this process", kind.__name__, exc_info=(kind, error, traceback))
