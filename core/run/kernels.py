"""Compile kernels with numba once an installation; the next process loads them from the disk.

Compiled code lies in the package's folder, or, where that cannot be written, in NUMBA_CACHE_DIR or the user's cache.
What the package's folder holds is read in either case: an installation by root serves users without rights.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from types import CodeType, FunctionType, ModuleType
from typing import Any

from numba import njit
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, InTreeCacheLocator
from numba.core.dispatcher import Dispatcher

DISPATCHER: Any = Dispatcher
"""Class of compiled functions; numba's own types of it lack the cache."""


class PackageLocator(InTreeCacheLocator):
    """The package's folder, whether it can be written or not."""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> PackageLocator:
        """Return the place of a function's compiled code."""
        return cls(py_func, py_file)


class KernelCacheImpl(CompileResultCacheImpl):
    """Where no folder can be written, the package's is still read."""

    _locator_classes: Any = (*CompileResultCacheImpl._locator_classes, PackageLocator)


class KernelCache(FunctionCache):
    """The compiled code of a kernel on the disk, which may be that of an older version of the package.

    Numba unpickles the types of the arguments before it compares the source, and raises where a named tuple among them
    has been renamed or moved since. Of the source it compares the kernel's own file; here the files of the kernels that
    it calls and the values of the constants that it uses belong to the key, too, because its code holds both.
    """

    _impl_class = KernelCacheImpl

    def __init__(self, function: Any) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        base, place = self._impl.filename_base, PackageLocator.from_function(function, function.__code__.co_filename)
        shipped = IndexDataCacheFile(place.get_cache_path(), base, place.get_source_stamp())  # type: ignore[no-untyped-call]
        self._files = (self._cache_file, shipped)

    def has_overload(self, sig: Any, target_context: Any) -> bool:
        """Return whether compiled code for a signature is on the disk."""
        target_context.refresh()
        return self._read(sig, target_context) is not None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled code for a signature, or None where there is none of these types."""
        target_context.refresh()
        found = self._read(sig, target_context)
        return None if found is None else self._impl.rebuild(target_context, found)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save the compiled code; where no folder can be written, the next process compiles it again."""
        with suppress(OSError):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]

    def _read(self, sig: Any, target_context: Any) -> Any:
        key = self._index_key(sig, target_context.codegen())
        for file in self._files:
            try:
                if (found := file.load(key)) is not None:  # type: ignore[no-untyped-call]
                    return found
            except OSError:  # a folder that this user may not read
                continue
            except (AttributeError, ImportError):
                with suppress(OSError):
                    file.flush()  # type: ignore[no-untyped-call]
        return None

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        digest = hashlib.sha256("\n".join(sorted(set(_describe_used(self._py_func, set())))).encode())
        return (*super()._index_key(sig, codegen), digest.hexdigest())  # type: ignore[no-untyped-call]


def _describe_used(function: Any, seen: set[Any]) -> Iterator[str]:
    """Describe what a kernel's code takes from elsewhere: kernels by their file's content, constants by their value."""
    seen.add(function)
    for name in _list_names(function.__code__):
        value: Any = function.__globals__.get(name)
        if isinstance(value, DISPATCHER):
            if value.py_func not in seen:
                yield f"{name}: {value._cache._impl.locator.get_source_stamp()!r}"
                yield from _describe_used(value.py_func, seen)
        elif value is not None and not isinstance(value, ModuleType | FunctionType | type):
            yield f"{name} = {value.tobytes() if hasattr(value, 'tobytes') else value!r}"


def _list_names(code: CodeType) -> Iterator[str]:
    """List the global names that a function and the functions within it use."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _list_names(constant)


def kernel(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function at its first call, with numba's options, and keeps the code."""

    def compile_at_first_call(function: Callable[..., Any]) -> Any:
        dispatcher = njit(**options)(function)
        dispatcher._cache = KernelCache(function)
        return dispatcher

    return compile_at_first_call
