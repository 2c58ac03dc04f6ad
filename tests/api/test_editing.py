"""Patterns that are edited over HTTP: what is wrong is told with its place."""

from __future__ import annotations

import pytest
from api_work import code_of
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.templates import load_template


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
    units = document | {"properties": {"units": "cm"}}
    assert [one["code"] for one in client.post("/v1/patterns/check", json=units).json()["findings"]] == [
        "pattern.units_missing"
    ]
    for hostile in (b"", b"\x00" * 100, b"[" * 60_000, b'{"pattern": {"panels": 7}}'):
        assert client.post("/v1/patterns/check", content=hostile).status_code in (400, 422)
    assert code_of(client.post("/v1/patterns/check", content=b" " * (5 * 1024**2))) == "request.too_large"


def test_document_is_changed_by_operations(client):
    """Broken where an operation does not reach the document, or one that cannot be done does not say where."""
    document = write_pattern(load_template("tshirt"))
    wanted = [
        {"op": "move", "points": [{"panel": "front", "vertex": 0}], "by_mm": [10, 0]},
        {"op": "split", "panel": "front", "edge": 8},
    ]
    answer = client.post("/v1/patterns/edit", json={"pattern": document, "operations": wanted})
    assert answer.status_code == 200 and answer.json()["is_sound"]
    vertices = answer.json()["pattern"]["pattern"]["panels"]["front"]["vertices"]
    assert len(vertices) == 10 and vertices[0] == pytest.approx([26.5, -63.5])
    assert vertices[8][0] == pytest.approx(-26.5), "the image of the moved point"
    unchanged = client.post("/v1/patterns/edit", json={"pattern": document, "operations": []})
    assert unchanged.json()["pattern"] == document
    refused = client.post("/v1/patterns/edit", json={"pattern": document, "operations": [{"op": "join", "seam": 1}]})
    assert (refused.status_code, code_of(refused)) == (422, "pattern.edit_bad")
    finding = refused.json()["findings"][0]
    assert finding["seam"] == 1 and finding["places"][0] == {"panel": "back", "edge": 2, "vertex": None, "point": None}
    units = document | {"properties": {"units": "cm"}}
    unread = client.post("/v1/patterns/edit", json={"pattern": units, "operations": []})
    assert (unread.status_code, code_of(unread)) == (422, "pattern.units_missing")
