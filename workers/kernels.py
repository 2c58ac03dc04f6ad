"""Compile the kernels that jobs use ahead of the first job, for this machine's processor.

`kernels.json` lists each kernel with the types of the arguments that a recovery, a person, an edit, a dressing and an
animation call it with; `make kernels` adds what is missing. Kernels that only kernels call are compiled with these.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from numba import types
from numba.core.dispatcher import Dispatcher

from ..core.run.errors import GarmentqError

TABLE = Path(__file__).with_name("kernels.json")
"""File with the kernels and the types of their arguments."""

ROOT = __name__.rpartition(".workers.")[0]
"""Name of the package."""

ARRAY = re.compile(r"array\((\w+), (\d)d, ([CFA])\)")
"""Numba's name of an array's type: element, number of axes, order in memory."""


class KernelTableBad(GarmentqError):
    """A kernel is called with a type that its table cannot name; pass contiguous arrays, numbers and tuples."""

    code = "kernels.table_bad"


@dataclass(frozen=True, order=True)
class KernelCall:
    """Describe the types with which a kernel is called.

    Attributes:
        kernel: Module below the package, colon, name.
        types: Each argument's type as JSON: numba's name, or a tuple's class and the types in it.
    """

    kernel: str
    types: str

    @classmethod
    def of(cls, dispatcher: Dispatcher, arguments: Sequence[Any]) -> KernelCall:
        """Describe one signature of a kernel.

        Raises:
            KernelTableBad: if a type cannot be named.
        """
        function = dispatcher.py_func
        name = f"{function.__module__.removeprefix(ROOT + '.')}:{function.__qualname__}"
        return cls(name, json.dumps([_encode(one) for one in arguments]))

    @property
    def dispatcher(self) -> Any:
        """Return the kernel."""
        return _find(self.kernel)

    @property
    def arguments(self) -> tuple[Any, ...]:
        """Return the arguments' types."""
        return tuple(_decode(one) for one in json.loads(self.types))

    def is_compiled(self) -> bool:
        """Return whether compiled code for this machine and the present source is on the disk."""
        dispatcher = self.dispatcher
        return bool(dispatcher._cache.has_overload(self.arguments, dispatcher.targetctx))


def read_table() -> list[KernelCall]:
    """Return the calls of `kernels.json`."""
    return [
        KernelCall(name, json.dumps(call)) for name, calls in json.loads(TABLE.read_text()).items() for call in calls
    ]


def write_table(calls: Iterable[KernelCall]) -> None:
    """Write `kernels.json`, one call a line."""
    lines: dict[str, list[str]] = {}
    for call in sorted(calls):
        lines.setdefault(call.kernel, []).append(call.types)
    blocks = [f" {json.dumps(name)}: [\n  " + ",\n  ".join(found) + "\n ]" for name, found in lines.items()]
    TABLE.write_text("{\n" + ",\n".join(blocks) + "\n}\n")


def list_uncompiled() -> list[KernelCall]:
    """Return the calls of the table whose code is not on the disk for this machine and the present source."""
    return [call for call in read_table() if not call.is_compiled()]


def compile_ahead(calls: Sequence[KernelCall]) -> float:
    """Compile some calls, keep their code on the disk and return the time that it took [s]."""
    start = time.monotonic()
    for call in calls:
        call.dispatcher.compile(call.arguments)
    return time.monotonic() - start


def _encode(kind: Any) -> Any:
    if isinstance(kind, types.BaseTuple):
        made = getattr(kind, "instance_class", None)
        name = "tuple" if made is None else f"{made.__module__.removeprefix(ROOT + '.')}:{made.__qualname__}"
        inner: Any = kind.types  # type: ignore[attr-defined]
        return [name, *(_encode(one) for one in inner)]
    name = str(kind)
    if (isinstance(kind, types.Array) and ARRAY.fullmatch(name)) or isinstance(kind, types.Number | types.Boolean):
        return name
    raise KernelTableBad(f"a kernel is called with '{name}', which its table cannot name; pass arrays and numbers.")


def _decode(value: Any) -> Any:
    if isinstance(value, list):
        name, *inner = value
        kinds = [_decode(one) for one in inner]
        return types.BaseTuple.from_types(kinds, None if name == "tuple" else _find(name))  # type: ignore[no-untyped-call]
    if found := ARRAY.fullmatch(value):
        return types.Array(_decode(found[1]), int(found[2]), found[3])  # type: ignore[arg-type]
    return getattr(types, value)


def _find(name: str) -> Any:
    module, _, attribute = name.partition(":")
    return getattr(import_module(f"{ROOT}.{module}"), attribute)
