"""Requests of jobs: frozen dataclasses, written to JSON and read back with every value checked."""

from __future__ import annotations

import re
import types
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from ...core.body.spec import BuiltinWearer, is_builtin
from ...core.run.errors import BadInput
from ...core.run.text import TextBad, has_unstorable_text

HASH = re.compile(r"[0-9a-f]{64}")
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]{0,99}")

T = TypeVar("T")


class RequestBad(BadInput):
    """The job's request does not fit its kind; submit it again with this version of garmentq."""

    code = "job.request_bad"


@dataclass(frozen=True)
class FileRef:
    """Describe a stored file: its key, and the cleaned name under which a job finds it."""

    sha256: str
    name: str

    def __post_init__(self) -> None:
        """Refuse a name that could be a path."""
        if not HASH.fullmatch(self.sha256) or not NAME.fullmatch(self.name):
            raise RequestBad(f"'{self.name[:40]}' with the key '{self.sha256[:12]}' names no stored file.")


def pack_request(request: Any) -> dict[str, Any]:
    """Return a request as JSON values; fields that are None by default are omitted while they are None.

    Raises:
        TextBad: if it contains text that no database can store.
    """
    values = {field.name: (getattr(request, field.name), field.default) for field in fields(request)}
    found = {name: _pack(one) for name, (one, default) in values.items() if one is not None or default is not None}
    if has_unstorable_text(found):
        raise TextBad()
    return found


def _pack(value: Any) -> Any:
    if isinstance(value, BuiltinWearer):
        return value.spec
    if is_dataclass(value) and not isinstance(value, type):
        found = {field.name: (getattr(value, field.name), field.metadata.get("is_left_out")) for field in fields(value)}
        return {name: _pack(one) for name, (one, is_left_out) in found.items() if one is not None or not is_left_out}
    if isinstance(value, list | tuple):
        return [_pack(one) for one in value]
    if isinstance(value, Mapping):
        return {str(key): _pack(one) for key, one in value.items()}
    return value


def find_files(request: Any, at: tuple[str, ...] = ()) -> Iterator[tuple[str, FileRef]]:
    """Yield the files of a request in JSON, each with its place: the path of field names that leads to it."""
    if not isinstance(request, Mapping):
        return
    if request.keys() == {"sha256", "name"}:
        yield "/".join(at), FileRef(**request)
        return
    for name, value in request.items():
        if NAME.fullmatch(name):
            yield from find_files(value, (*at, name))


def read_request(kind: type[T], given: Mapping[str, Any]) -> T:
    """Build a request from JSON values.

    Raises:
        RequestBad: if a field is missing, unknown, or of another type.
        BadInput: if the dataclass itself refuses a value.
    """
    hints, known = get_type_hints(kind), {field.name: field for field in fields(kind)}  # type: ignore[arg-type]
    required = {f.name for f in known.values() if f.default is MISSING and f.default_factory is MISSING}
    wrong = sorted((set(given) - set(known)) | (required - set(given)))
    if wrong:
        has = "unknown" if wrong[0] in given else "missing"
        raise RequestBad(f"'{str(wrong[0])[:40]}' is {has}. {RequestBad().message}")
    return kind(**{name: _read(hints[name], value, name) for name, value in given.items()})


def _read(hint: Any, value: Any, name: str) -> Any:
    if get_origin(hint) in (Union, types.UnionType):
        for one in get_args(hint):
            if _fits(one, value):
                return _read(one, value, name)
    elif _fits(hint, value):
        if hint is BuiltinWearer:
            return BuiltinWearer(value)
        if hint is float:
            return _read_number(value, name)
        if is_dataclass(hint):
            return read_request(hint, value)  # type: ignore[arg-type]
        if get_origin(hint) is tuple:
            return tuple(_read(get_args(hint)[0], one, name) for one in value)
        if get_origin(hint) in (dict, Mapping):
            return {str(key): _read(get_args(hint)[1], one, str(key)) for key, one in value.items()}
        return value
    raise RequestBad(f"'{name}' cannot be {value!r:.60}. {RequestBad().message}")


def _read_number(value: float, name: str) -> float:
    try:
        return float(value)  # 30 and 30.0 are the same job
    except OverflowError as error:
        raise RequestBad(f"'{name}' is too large. {RequestBad().message}") from error


def _fits(hint: Any, value: Any) -> bool:
    """Return whether a JSON value can be of a type; parts of a dataclass or tuple are checked when they are read."""
    origin = get_origin(hint) or hint
    if hint is Any:
        return True
    if hint is BuiltinWearer:
        return isinstance(value, str) and is_builtin(value)
    if is_dataclass(hint) or origin in (dict, Mapping):
        return isinstance(value, Mapping)
    if origin is tuple:
        return isinstance(value, list)
    if hint is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    return isinstance(value, origin) and (hint is bool or not isinstance(value, bool))
