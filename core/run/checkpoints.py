"""Checkpoints: frozen dataclasses as plain arrays and back, bound to the input from which they were computed.

A stage that may resume a killed run calls `load` first and `save` after each iteration. A checkpoint of another set of
fields or of another input, or an incomplete one, is ignored: the stage then starts anew.
"""

from __future__ import annotations

import hashlib
import json
import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from .hooks import Arrays, Hooks

T = TypeVar("T")

FORMAT_KEY, INPUTS_KEY = "format", "inputs"
"""Keys in addition to the fields: hashes of the type's structure and of the inputs."""

_NUMBERS: dict[Any, type] = {bool: np.bool_, int: np.int64, float: np.float64}


class IncompleteCheckpoint(ValueError):
    """Arrays are not those that `pack` made of the type."""


def save(hooks: Hooks, name: str, state: Any, *inputs: Any) -> None:
    """Save a dataclass under a name.

    Args:
        hooks: Store the arrays.
        name: Name of the checkpoint.
        state: The dataclass.
        inputs: Arrays and numbers from which `state` was computed.
    """
    hooks.save_checkpoint(name, {**pack(state), INPUTS_KEY: _write(_digest(inputs))})


def load(hooks: Hooks, name: str, kind: type[T], *inputs: Any) -> T | None:
    """Return what an earlier run of the job saved under a name, or None where nothing fits type and inputs."""
    kept = hooks.load_checkpoint(name)
    if kept is None or not np.array_equal(kept.get(INPUTS_KEY, ()), _write(_digest(inputs))):
        return None
    return unpack(kind, {key: kept[key] for key in kept if key != INPUTS_KEY})


def pack(value: Any) -> dict[str, np.ndarray]:
    """Return a dataclass as arrays by dotted names.

    Fields may be arrays, numbers, texts, enums, dataclasses of such, tuples and dictionaries of one kind of them, and
    each of them or None; a dictionary of any values by text has JSON values.

    Raises:
        TypeError: where a field is of another type.
    """
    arrays = {FORMAT_KEY: _write(fingerprint(type(value)))}
    _put(type(value), value, "", arrays)
    return arrays


def unpack(kind: type[T], arrays: Arrays) -> T | None:
    """Return the packed dataclass, or None where the arrays are another type's, another version's or incomplete."""
    left = dict(arrays)
    try:
        if _read(left.pop(FORMAT_KEY)) != fingerprint(kind):
            return None
        value: T = _take(kind, "", left)
    except (KeyError, ValueError):
        return None
    return None if left else value


def fingerprint(kind: type) -> str:
    """Return a hash of a type's fields, their names and types, recursively."""
    return hashlib.sha256(_describe(kind).encode()).hexdigest()


def _describe(kind: Any) -> str:
    if is_dataclass(kind):
        return f"({', '.join(f'{name}: {_describe(hint)}' for name, hint in _fields(kind))})"
    if isinstance(kind, type) and issubclass(kind, Enum):
        return f"[{', '.join(kind.__members__)}]"
    inner = get_args(kind)
    return f"{get_origin(kind)}<{', '.join(map(_describe, inner))}>" if inner else repr(kind)


def _fields(kind: Any) -> list[tuple[str, Any]]:
    hints = get_type_hints(kind)
    return [(field.name, hints[field.name]) for field in fields(kind)]


def _put(kind: Any, value: Any, at: str, arrays: dict[str, np.ndarray]) -> None:
    """Add a value of a type to arrays, under names that begin with `at`."""
    if (inner := _optional(kind)) is not None:
        arrays[f"{at}?"] = np.array(value is not None)
        if value is not None:
            _put(inner, value, at, arrays)
    elif is_dataclass(kind):
        for name, hint in _fields(kind):
            _put(hint, getattr(value, name), f"{at}.{name}" if at else name, arrays)
    elif get_origin(kind) is tuple:
        for index, (hint, each) in enumerate(zip(_items(kind, len(value)), value, strict=True)):
            _put(hint, each, f"{at}.{index}", arrays)
        arrays[f"{at}#"] = np.array(len(value))
    elif _is_json(kind):
        arrays[at] = _write(json.dumps(value))
    elif get_origin(kind) in (dict, Mapping):
        keys, values = map(_many, get_args(kind))
        _put(keys, tuple(value), f"{at}:", arrays)
        _put(values, tuple(value.values()), at, arrays)
    elif kind is np.ndarray:
        if (array := np.asarray(value)).dtype == object:
            raise TypeError(f"{at} holds Python objects")
        arrays[at] = array
    elif kind in _NUMBERS:
        arrays[at] = np.array(value, dtype=_NUMBERS[kind])
    elif kind is str:
        arrays[at] = _write(value)
    elif isinstance(kind, type) and issubclass(kind, Enum):
        arrays[at] = _write(value.name)
    else:
        raise TypeError(f"{at} is of type {kind}, which no checkpoint holds")


def _take(kind: Any, at: str, arrays: dict[str, np.ndarray]) -> Any:
    """Remove a value of a type from arrays; the reverse of `_put`."""
    if (inner := _optional(kind)) is not None:
        return _take(inner, at, arrays) if _number(bool, f"{at}?", arrays) else None
    if is_dataclass(kind):
        values = {name: _take(hint, f"{at}.{name}" if at else name, arrays) for name, hint in _fields(kind)}
        return kind(**values)  # type: ignore[operator]
    if get_origin(kind) is tuple:
        hints = _items(kind, _number(int, f"{at}#", arrays))
        return tuple(_take(hint, f"{at}.{index}", arrays) for index, hint in enumerate(hints))
    if _is_json(kind) and at in arrays:
        return json.loads(_read(arrays.pop(at)))
    if get_origin(kind) in (dict, Mapping):  # also of JSON values, as 0.1.0 stored empty ones
        keys, values = map(_many, get_args(kind))
        return dict(zip(_take(keys, f"{at}:", arrays), _take(values, at, arrays), strict=True))
    if kind in _NUMBERS:
        return _number(kind, at, arrays)
    if kind is str:
        return _read(arrays.pop(at))
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind[_read(arrays.pop(at))]
    return arrays.pop(at)


def _is_json(kind: Any) -> bool:
    """Check whether a type is a dictionary of JSON values."""
    return get_origin(kind) in (dict, Mapping) and get_args(kind) == (str, Any)


def _optional(kind: Any) -> Any | None:
    """Return X of `X | None`, or None for another type."""
    inner = get_args(kind)
    if get_origin(kind) not in (Union, types.UnionType) or len(inner) != 2 or type(None) not in inner:
        return None
    return inner[0] if inner[1] is type(None) else inner[1]


def _many(kind: Any) -> Any:
    """Return the type of a tuple of any length with items of one type."""
    return types.GenericAlias(tuple, (kind, ...))


def _items(kind: Any, count: int) -> tuple[Any, ...]:
    """Return the types of a tuple's items."""
    inner = get_args(kind)
    items = inner[:1] * count if inner[-1] is Ellipsis else inner
    if len(items) != count:
        raise IncompleteCheckpoint(f"{count} items of a {kind}")
    return items


def _number(kind: type, at: str, arrays: dict[str, np.ndarray]) -> Any:
    array = np.asarray(arrays.pop(at))
    if array.shape != () or array.dtype != _NUMBERS[kind]:
        raise IncompleteCheckpoint(f"{at} is no {kind.__name__}")
    return array.item()


def _digest(inputs: tuple[Any, ...]) -> str:
    """Return a hash of arrays and numbers: their types, shapes and every bit."""
    found = hashlib.sha256()
    for each in inputs:
        array = np.ascontiguousarray(each)
        found.update(f"{array.dtype.str}{array.shape}".encode())
        found.update(array.tobytes())
    return found.hexdigest()


def _write(text: str) -> np.ndarray:
    return np.frombuffer(text.encode(), dtype=np.uint8)


def _read(codes: np.ndarray) -> str:
    if (array := np.asarray(codes)).dtype != np.uint8:
        raise IncompleteCheckpoint("no text")
    return array.tobytes().decode()
