"""Requests made up from the OpenAPI document, 150 in the suite and 2000 at night, each answer checked against it."""

from __future__ import annotations

import shutil
from collections import Counter
from dataclasses import replace

import pytest
import schemathesis
from api_client import LIMITS
from api_work import finish, make_key, make_ply
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.templates import load_template
from garmentq.service.api.app import make_app
from garmentq.service.database import open_database
from garmentq.service.families import cancel
from garmentq.service.stores import open_store
from garmentq.service.submission import Order, submit
from garmentq.service.templates import keep_template
from garmentq.service.uploads import keep_upload
from garmentq_home import make_settings
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from schemathesis import GenerationMode
from schemathesis.python import asgi
from schemathesis.specs.openapi import checks

AMOUNTS = (
    pytest.param(3, 150, (200, 201, 202, 404, 422), id="suite"),
    pytest.param(36, 2000, (200, 201, 202, 404, 409, 422), id="nightly", marks=pytest.mark.nightly),
)
"""Requests to each route that fit its description and that do not, how many there are at least in all, and the statuses
of which there are at least a sixth as many as requests to one route."""

HOST = "http://127.0.0.1"
UNBOUND = replace(LIMITS, requests_per_second=1e9, burst=10**9)
QUICK = settings(
    derandomize=True, database=None, deadline=None, phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
CHECKS = [
    checks.status_code_conformance, checks.content_type_conformance, checks.response_headers_conformance,
    checks.response_schema_conformance,
]  # fmt: skip
ORDER = {"body": "builtin:female", "template": "skirt"}
FREE = ("queue", "force", "name", "tags")
"""What an order that is taken may say besides."""


@pytest.fixture(scope="module")
def service(tmp_path_factory, blank_database):
    """Return a service in this process, a key to it, and what it knows: jobs, uploads, a template, another key."""
    folder = tmp_path_factory.mktemp("made_up")
    chosen = make_settings(folder / "home")
    chosen.home.mkdir()
    shutil.copy(blank_database, chosen.home / "garmentq.db")
    database, store = open_database(chosen), open_store(chosen)
    header = make_key(database, "admin", "admin", quota=1_000_000)
    keys = [make_key(database, "other"), header]
    scan, pattern = folder / "skirt.ply", folder / "mine.json"
    scan.write_bytes(make_ply())
    save_pattern(load_template("skirt"), pattern)
    keep_template(database, store, "mine", pattern, "skirt", 2)
    from garmentq.service.keys import list_keys

    admin = next(row.id for row in list_keys(database) if row.name == "admin")
    other = next(row.id for row in list_keys(database) if row.name == "other")
    digest = keep_upload(database, store, admin, scan, (scan.name, "scans")).sha256
    bodies = ["builtin:female,height=1.7", *(f"builtin:male,height=1.{tenth}" for tenth in range(5, 9))]
    jobs = [submit(database, store, Order(scan, body)).job for body in bodies]
    finish(chosen, database, store, jobs[0], folder / "made")
    for job in jobs[1:]:
        cancel(database, job)
    known = {"job": jobs, "sha256": [digest], "key": [other], "name": ["pattern.svg", "mine", "denim"]}
    app = make_app(chosen, UNBOUND)
    with asgi.get_client(app) as client:
        yield app, client, header, known
    assert keys
    database.dispose()
    app.state.rooms.database.dispose()


@pytest.mark.slow
@pytest.mark.parametrize(("each", "least", "answers"), AMOUNTS)
def test_no_request_is_a_fault(service, each, least, answers):
    """Broken where an answer is a 5xx, or has a status, type or form that /openapi.json does not tell."""
    app, client, header, known = service
    quick = settings(QUICK, max_examples=each)
    schema = schemathesis.openapi.from_dict(app.openapi())
    schema.app = app
    schema.config.update(base_url=HOST, request_timeout=600.0)  # a busy machine is no fault
    statuses = Counter()

    def ask(case, pick):
        for name, values in known.items():
            if pick and case.method != "DELETE" and name in (case.path_parameters or {}):
                case.path_parameters[name] = values[pick % len(values)]
        if pick and isinstance(case.body, dict) and "scan" in case.body:
            case.body |= {"scan": known["sha256"][0], "body": "builtin:female", "labels": None, "pattern": None}
            if pick % 2:  # of the rest only what any order may say; no order twice
                free = {name: case.body[name] for name in FREE if name in case.body}
                case.body = {**ORDER, "scan": known["sha256"][0], "settings": {"seed": sum(statuses.values())}, **free}
        if pick and case.headers:
            case.headers.pop("Authorization", None)
        answer = case.call(session=client, headers=header)
        statuses[answer.status_code] += 1
        assert answer.status_code < 500, (case.as_curl_command(), answer.text)
        case.validate_response(answer, checks=CHECKS if pick else [*CHECKS, checks.negative_data_rejection])

    for found in schema.get_all_operations():
        route = found.ok()
        picks = st.integers(0, 6)
        quick(given(route.as_strategy(generation_mode=GenerationMode.POSITIVE), picks)(ask))()
        if route.path_parameters or route.query or route.headers or route.body:
            quick(given(route.as_strategy(generation_mode=GenerationMode.NEGATIVE), picks)(ask))()
    assert sum(statuses.values()) >= least, statuses
    assert min(statuses[status] for status in answers) >= max(each // 6, 1), statuses
