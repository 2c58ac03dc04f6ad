"""Requests of jobs: frozen dataclasses, written to JSON and read back with every value checked."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from ...core.body.spec import BuiltinWearer
from ...core.run.errors import BadInput
from ...core.run.text import TextBad, has_unstorable_text
from ..adapters import ReadText, get_adapter

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

HASH = re.compile(r"[0-9a-f]{64}")
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]{0,99}")

T = TypeVar("T")

BuiltinText = Annotated[BuiltinWearer, ReadText(BuiltinWearer)]
"""A built-in body, in JSON its description."""


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


def read_request(kind: type[T], values: Mapping[str, Any]) -> T:
    """Build a request from JSON values, each of exactly its field's type; a number may be an integer.

    Raises:
        RequestBad: if a field is missing, unknown, or of another type.
        TextBad: if a text cannot be stored.
        BadInput: if the dataclass itself refuses a value.
    """
    from pydantic import ValidationError

    _check_json(values)
    try:
        return get_adapter(kind).validate_json(json.dumps(values), strict=True, extra="forbid")
    except RecursionError:
        raise RequestBad(f"the request is nested too deeply. {RequestBad().message}") from None
    except ValidationError as error:
        found = max(error.errors(include_url=False), key=lambda one: len(one["loc"]))  # inside the type that fits best
        if found["type"] == "json_invalid" and has_unstorable_text(values):
            raise TextBad() from None
        raise RequestBad(f"{_explain(found, values)} {RequestBad().message}") from None


def _check_json(value: Any) -> None:
    """Refuse what JSON has no value for, and an integer too large for a float, which pydantic reads as infinite."""
    waiting = [("request", value)]
    while waiting:
        name, one = waiting.pop()
        if isinstance(one, Mapping):
            waiting += [(str(key)[:40], part) for key, part in one.items()]
        elif isinstance(one, list | tuple):
            waiting += [(name, part) for part in one]
        elif isinstance(one, int) and abs(one) > sys.float_info.max:
            raise RequestBad(f"'{name}' is too large. {RequestBad().message}")
        elif not isinstance(one, str | int | float | None):
            raise RequestBad(f"'{name}' cannot be {one!r:.60}. {RequestBad().message}")


def _explain(error: ErrorDetails, value: Any) -> str:
    """Return what is wrong with the values given, by the name of the field."""
    place, name = error["loc"], "request"
    if error["type"] in ("missing", "unexpected_keyword_argument") and isinstance(place[-1], str):
        return f"'{place[-1][:40]}' is {'missing' if error['type'] == 'missing' else 'unknown'}."
    for step in place:  # besides names and numbers of values, a place has the types that were tried
        if isinstance(value, Mapping) and step in value:
            name, value = str(step)[:40], value[step]
        elif isinstance(value, list) and isinstance(step, int) and step < len(value):
            value = value[step]
    return f"'{name}' cannot be {error['input']!r:.60}."
