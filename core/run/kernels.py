"""Compile kernels with numba once an installation; the next process loads them from the disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache


class KernelCache(FunctionCache):
    """The compiled code of a kernel on the disk, which may be that of an older version of the package.

    Numba unpickles the types of the arguments before it compares the source's time, and raises where a named tuple
    among them has been renamed or moved since.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled code for a signature, or None where there is none of these types; others are dropped."""
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except (AttributeError, ImportError):
            self.flush()  # type: ignore[no-untyped-call]
            return None


def kernel(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function at its first call, with numba's options, and keeps the code."""

    def compile_at_first_call(function: Callable[..., Any]) -> Any:
        dispatcher = njit(**options)(function)
        dispatcher._cache = KernelCache(function)  # type: ignore[no-untyped-call]
        return dispatcher

    return compile_at_first_call
