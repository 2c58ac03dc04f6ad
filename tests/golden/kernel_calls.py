"""The calls of kernels that jobs make: `make kernels` adds those of the golden scenes to the table of the package.

A call that no scene makes is added by hand to `workers/kernels.json`; a kernel without any fails a test.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from garmentq.workers.kernels import KernelCall, read_table, write_table
from numba.core.dispatcher import Dispatcher

CORE = Path(__file__).parents[2] / "core"


def list_kernels() -> Iterator[Dispatcher]:
    """List every kernel of core."""
    for path in sorted(CORE.rglob("*.py")):
        if "@kernel(" in path.read_text(encoding="utf-8"):
            name = ".".join(("garmentq", "core", *path.relative_to(CORE).with_suffix("").parts))
            for value in vars(importlib.import_module(name)).values():
                if isinstance(value, Dispatcher) and value.py_func.__module__ == name:
                    yield value


@contextmanager
def record_calls() -> Iterator[set[KernelCall]]:
    """Fill a set with the calls of core's kernels by Python within the block, if they are new to this process."""
    found: set[KernelCall] = set()
    compile_for = Dispatcher._compile_for_args

    def record(dispatcher: Dispatcher, *arguments: object, **named: object) -> object:
        before = set(dispatcher.signatures)
        made = compile_for(dispatcher, *arguments, **named)
        if dispatcher.py_func.__module__.startswith("garmentq.core."):
            found.update(KernelCall.of(dispatcher, types) for types in set(dispatcher.signatures) - before)
        return made

    with patch.object(Dispatcher, "_compile_for_args", record):
        yield found


def main() -> None:
    """Add the calls of every scene to the table."""
    from golden_scenes import SCENES, Shift

    with record_calls() as found:
        for run in SCENES.values():
            run(Shift())
    missing = found - set(read_table())
    write_table({*read_table(), *missing})
    sys.stdout.write("".join(f"{call.kernel}\n" for call in sorted(missing)) or "the table has every call\n")


if __name__ == "__main__":
    main()
