"""The lines of a bench: a failure is stored in its line, and a line is written to the disk as soon as it is known."""

from __future__ import annotations

import json
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from ...core.run.errors import GarmentqError

Line = dict[str, Any]
T = TypeVar("T")


@contextmanager
def keep_failure(line: Line) -> Iterator[None]:
    """Run the code that fills a line; store its CPU seconds, or its failure, so that the other lines are not lost."""
    started = time.process_time()
    try:
        yield
    except GarmentqError as error:
        line["error"] = {"code": error.code, "message": error.message}
    except Exception as error:  # a bug: its traceback goes to the log
        traceback.print_exc()
        line["error"] = {"code": "bench.exception", "message": f"{type(error).__name__}: {error}"}
    if line["cpu_seconds"] is None:
        line["cpu_seconds"] = time.process_time() - started


@contextmanager
def append_lines(path: Path) -> Iterator[Callable[[Line], None]]:
    """Yield a function that appends a line to a file of JSON lines and flushes it."""
    with path.open("a", encoding="utf-8") as out:

        def write(line: Line) -> None:
            out.write(json.dumps(line, allow_nan=False) + "\n")
            out.flush()

        yield write


def answer_order(arguments: Sequence[str], kind: type[T], run: Callable[[T], Line]) -> None:
    """Read the order of a bench's process, run it, and write its line.

    Args:
        arguments: ORDER.json and LINE.json.
        kind: The dataclass of the order.
        run: Runs the order.
    """
    order, answer = (Path(name) for name in arguments)
    line = run(kind(**json.loads(order.read_text(encoding="utf-8"))))
    answer.write_text(json.dumps(line, allow_nan=False), encoding="utf-8")
