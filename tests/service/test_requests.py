"""Requests in JSON: stored ones open and keep their hash, and what does not fit is refused by name."""

from __future__ import annotations

import hashlib
import json

import pytest
from garmentq.core.run.errors import BadInput
from garmentq.service.kinds import find_kind, pack_request, read_request
from garmentq.service.settings import ServiceSettings

FILE = {"sha256": 64 * "a", "name": "anna.ply"}
FABRIC = {
    "name": "mine", "H00": 1.0, "H01": 2, "H11": 3.0, "H22": 4.5, "k": 1e-5, "density": 0.1,
    "sources": [["k", "measured: loop"]],
}  # fmt: skip
SETTINGS = {"preset": "thesis", "fabric": FABRIC, "seed": 3, "colour_tolerance": 30, "parts": "neckline=v"}

DEEP: dict = {}
for _ in range(100_000):
    DEEP = {"a": DEEP}

STORED = [
    ("recover",
     {"scan": FILE, "body": "builtin:female,height=1.70", "template": None, "settings": SETTINGS}, "f52e5383"),
    ("recover",
     {"scan": FILE, "body": FILE, "template": FILE, "settings": {"fabric": "denim"}, "labels": FILE}, "d7b5d0ba"),
    ("recover", {"scan": None, "body": None, "template": None, "settings": {}, "part": "upper"}, "90710958"),
    ("person", {"scan": FILE}, "119115d6"),
    (
        "person",
        {"scan": FILE, "settings": SETTINGS, "body": "builtin:male", "wearing": "upper,lower", "marks": ["upper=1,2,3"],
         "choices": {"upper": {"template": FILE, "fabric": FABRIC}, "lower": {"template": "skirt", "parts": "a=b"}}},
        "4b04503e",
    ),
    ("dress", {"body": FILE, "units": "cm", "up": "z", "fabric": FABRIC}, "812d9fa7"),
    ("refit", {"body": "builtin:female", "pose": "A"}, "12df4d73"),
    ("outfit", {"body": "builtin:female", "order": "lower,upper"}, "e412fe43"),
    ("edit", {"pattern": FILE, "recovered": FILE}, "4709cd95"),
    ("animate", {"motion": "walk", "fps": 30, "end": 2, "keep_motion": True}, "857347dd"),
    ("animate", {"motion": FILE, "damping": 1}, "fe0a520f"),
    ("export",
     {"format": "svg", "step": 4, "first": -1, "sizes": [{"name": "S", "bust": 90}, {"name": "M"}]}, "669a3fcf"),
]  # fmt: skip
"""Kind, request as earlier versions stored it, and the first eight digits of the hash of it packed again."""

REFUSED = [
    ("animate", {}, "job.request_bad", "'motion' is missing."),
    ("animate", {"motion": "walk", "speed": 1}, "job.request_bad", "'speed' is unknown."),
    ("animate", {"motion": {**FILE, "size": 1}}, "job.request_bad", "'size' is unknown."),
    ("animate", {"motion": {**FILE, "sha256": 1}}, "job.request_bad", "'sha256' cannot be 1."),
    ("animate", {"motion": "walk", "fps": "30"}, "job.request_bad", "'fps' cannot be '30'."),
    ("animate", {"motion": "walk", "fps": True}, "job.request_bad", "'fps' cannot be True."),
    ("animate", {"motion": "walk", "keep_motion": 1}, "job.request_bad", "'keep_motion' cannot be 1."),
    ("animate", {"motion": "walk", "fps": 10**400}, "job.request_bad", "'fps' is too large."),
    ("animate", {"motion": "walk", "fps": {1}}, "job.request_bad", "'fps' cannot be {1}."),
    ("animate", {"motion": "walk", "fps": float("inf")}, "animate.settings_bad", "fps inf, "),
    ("animate", {"motion": DEEP}, "job.request_bad", "the request is nested too deeply."),
    ("animate", {"motion": json.loads(500 * "[" + 500 * "]")}, "job.request_bad", "'request' cannot be "),
    ("animate", {"motion": "half \ud800"}, "text.bad", "A text has NUL "),
    ("dress", {"body": "anna.ply"}, "job.request_bad", "'body' cannot be 'anna.ply'."),
    ("dress", {"fabric": {**FABRIC, "k": "soft"}}, "job.request_bad", "'k' cannot be 'soft'."),
    ("export", {"format": "pdf", "first": -2.0}, "job.request_bad", "'first' cannot be -2.0."),
    ("export", {"format": "pdf", "sizes": [{"name": "S"}, {"bust": 9}]}, "job.request_bad", "'name' is missing."),
    ("person", {"scan": FILE, "marks": ["a", 1]}, "job.request_bad", "'marks' cannot be 1."),
    ("person", {"scan": FILE, "choices": {"upper": 3}}, "job.request_bad", "'upper' cannot be 3."),
]  # fmt: skip
"""Kind, request, code and the beginning of the message."""


@pytest.mark.parametrize(("kind", "stored", "start"), STORED)
def test_a_stored_request_keeps_its_hash(kind, stored, start):
    """Broken where a stored request no longer opens, or an equal order would be another job and be computed anew."""
    request = read_request(find_kind(ServiceSettings(), kind).request, stored)
    packed = json.dumps(pack_request(request), sort_keys=True)
    assert read_request(type(request), json.loads(packed)) == request
    assert hashlib.sha256(packed.encode()).hexdigest()[:8] == start


@pytest.mark.parametrize(("kind", "given", "code", "message"), REFUSED)
def test_what_does_not_fit_is_named(kind, given, code, message):
    """Broken where a value of another type is converted or stored, or the message names another field."""
    with pytest.raises(BadInput) as caught:
        read_request(find_kind(ServiceSettings(), kind).request, given)
    assert (caught.value.code, caught.value.message[: len(message)]) == (code, message)
