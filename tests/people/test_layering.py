"""The order in which a person's garments lie over each other."""

from __future__ import annotations

from typing import Any

import pytest
from garmentq.service.layering import order_garments


def find(part: str, **hidden: bool) -> dict[str, Any]:
    """Return a garment whose openings, by name, are hidden or seen."""
    return {"part": part, "contours": [{"name": name, "is_inferred": is_hidden} for name, is_hidden in hidden.items()]}


CASES = [
    ("lower upper", find("upper", hem=False), find("lower", waist=True)),
    ("upper lower", find("upper", hem=True), find("lower", waist=False)),
    ("lower upper", find("upper", hem=False), find("lower", waist=False)),
    ("lower upper", find("upper", hem=True), find("lower", waist=True)),
    ("lower upper outer", find("outer", hem=False), find("upper", hem=False), find("lower", waist=True)),
    ("upper lower outer", find("upper", hem=True), find("lower", waist=False), find("outer", hem=False)),
    ("one-piece outer", find("one-piece", hem=False), find("outer", hem=False)),
    ("lower upper", find("upper"), find("lower")),
    ("upper lower", find("upper"), find("lower", waist=False)),
    ("lower", find("lower", waist=False)),
]


@pytest.mark.parametrize(("expected", "garments"), [(words, found) for words, *found in CASES])
def test_top_over_bottom_unless_tucked(expected, garments):
    """Broken where a tucked top is worn over the waistband, a hanging one under it, or a coat under a shirt."""
    assert order_garments({"garments": garments}) == tuple(expected.split())


def test_what_is_not_recovered_has_no_layer():
    """Broken where an outfit waits for a garment that has no recovery."""
    upper = find("upper", hem=True) | {"problem": {"code": "segment.unsure", "message": "."}}
    assert order_garments({"garments": [upper, find("lower", waist=False)]}) == ("lower",)
