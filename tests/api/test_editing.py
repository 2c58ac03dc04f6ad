"""Patterns that are edited over HTTP: what is wrong is told with its place."""

from __future__ import annotations

import pytest
from api_work import code_of
from garmentq.core.pattern import load_template, write_pattern


def test_document_is_examined(client):
    """Broken where a document's lengths or faults do not reach the caller, or something of it is kept."""
    document = write_pattern(load_template("tshirt"))
    found = client.post("/v1/patterns/check", json=document)
    assert found.status_code == 200 and found.json()["is_sound"]
    assert found.json()["seams"][5]["lengths_mm"] == pytest.approx([420.0, 420.0])
    document["pattern"]["panels"]["front"]["vertices"][0] = [25.5, -80.0]
    broken = client.post("/v1/patterns/check", json=document).json()
    assert not broken["is_sound"]
    assert [(one["code"], one["seam"]) for one in broken["findings"]] == [("pattern.seam_unequal", 5)]
    assert not client.post("/v1/patterns/check", json={"pattern": {"panels": 7}}).json()["is_sound"]
    for hostile in (b"", b"\x00" * 100, b"[" * 60_000):
        assert code_of(client.post("/v1/patterns/check", content=hostile)) == "pattern.unreadable"
    assert code_of(client.post("/v1/patterns/check", content=b" " * (5 * 1024**2))) == "request.too_large"
