"""The log of a process: plain lines, or one JSON object a line with job, attempt and stage."""

from __future__ import annotations

import json
import logging
import sys
import time
from contextvars import ContextVar

from ..core.run.errors import keep_printable

REQUEST: ContextVar[str] = ContextVar("request", default="")
"""Id of the HTTP request that is being answered, as in its response; empty elsewhere."""

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
    """Send this process's log to standard error."""
    handler = logging.StreamHandler(sys.stderr)
    readable = PlainLines("%(asctime)s %(levelname)s %(processName)s %(message)s")
    handler.setFormatter(JsonLines() if as_json else readable)
    logging.basicConfig(handlers=[handler], level=logging.INFO)
    logging.getLogger("alembic").setLevel(logging.WARNING)
