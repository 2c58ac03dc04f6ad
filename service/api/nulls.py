"""Keep null in the OpenAPI document's examples: FastAPI drops every field that is None, in examples too."""

from __future__ import annotations

from typing import Any

NULL = "\0null"
"""Placeholder for null until FastAPI is done; no example has such a text."""


def hide_nulls(value: Any) -> Any:
    """Return an example with the placeholder instead of each None."""
    return _replace(value, None, NULL)


def show_nulls(value: Any) -> Any:
    """Return a document with None instead of each placeholder."""
    return _replace(value, NULL, None)


def _replace(value: Any, old: object, new: object) -> Any:
    if isinstance(value, dict):
        return {name: _replace(inner, old, new) for name, inner in value.items()}
    if isinstance(value, list):
        return [_replace(inner, old, new) for inner in value]
    return new if value == old else value
