"""What is understood of a scan before a job is asked for."""

from __future__ import annotations

from pathlib import Path

import pytest
from garmentq.core.body.presence import ScanPartial
from garmentq.core.run.errors import BadInput
from garmentq.service import inspect_scan as found_by
from garmentq.service.api.limits import ApiLimits
from garmentq.service.api.meter import LimitedFull, LimitedOpen, Meter
from garmentq.service.inspect_scan import inspect_order
from garmentq.service.inspection import BodyNotBuiltin, inspect_scan

DATA = Path(__file__).parents[2] / "examples" / "data"


def test_a_person_and_a_garment_are_told_apart(monkeypatch):
    """Broken where the example's person is no person, her shirt alone one, or what the shirt needs is not said."""
    person = inspect_order(str(DATA / "person.ply"), is_quick=True)
    assert (person["as"], person["is_sure"], person["needs"]) == ("person", False, None)
    assert person["scan"]["has_colours"] and person["scan"]["has_labels"] and person["scan"]["up"] == "y"
    said = inspect_order(str(DATA / "garment.ply"), given_as="garment")
    assert said["needs"]["code"] == "body.missing" and said["scan"]["face_count"] == 17444
    found = inspect_order(str(DATA / "garment.ply"), is_quick=True)
    assert {**said, "is_sure": True} == found

    def refuse(*points):
        raise ScanPartial()

    monkeypatch.setattr(found_by, "fit_person", refuse)
    with pytest.raises(BadInput, match="scanned alone needs its wearer"):
        inspect_order(str(DATA / "person.ply"))
    with pytest.raises(BadInput, match="scan all of the person"):
        inspect_order(str(DATA / "person.ply"), given_as="person")


@pytest.mark.nightly
def test_the_wearer_is_found():
    """Broken where a second look does not find the example's wearer, or a shirt's openings on a built-in body."""
    person = inspect_scan(DATA / "person.ply", {})
    assert person["is_sure"] and abs(person["body"]["height_m"] - 1.66) < 0.02


def test_few_are_looked_at_at_a_time():
    """Broken where many questions take the machine from the jobs, or one key takes the share of the others."""
    limits = ApiLimits()
    meter = Meter(limits)
    held = [meter.limited(f"key {number}") for number in range(limits.limited)]
    for one in held:
        one.__enter__()
    with pytest.raises(LimitedOpen), meter.limited("key 0"):
        pass
    with pytest.raises(LimitedFull), meter.limited("another"):
        pass
    held[0].__exit__(None, None, None)
    for key in ("another", "key 0", ""):
        with meter.limited(key):
            pass


def test_a_path_is_no_body(tmp_path):
    """Broken where a path is taken for a body."""
    with pytest.raises(BodyNotBuiltin):
        inspect_scan(tmp_path, {"body": "/etc/passwd"})
