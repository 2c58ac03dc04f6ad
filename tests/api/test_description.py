"""/openapi.json as other programs read it: valid, with no end that hangs loose, and true to what is answered."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from api_work import ask
from garmentq.service.api.media_types import MEDIA_TYPES
from garmentq.service.families import cancel
from garmentq.service.jobs import claim, fail
from garmentq.service.models import DeliveryRow, WebhookRow
from garmentq.service.webhooks import claim_due_messages, create_webhook, queue_trial
from jsonschema import Draft202012Validator
from openapi_spec_validator import OpenAPIV31SpecValidator

OPERATIONS = """
assign_jobs cancel_job change_job check_pattern create_job create_jobs create_key create_share create_subject
create_webhook delete_job delete_material delete_person delete_subject delete_template delete_webhook
download_artifact download_export download_result edit_pattern follow_job forget_body forget_labels forget_motion
forget_pattern forget_scan import_material import_template inspect_scan list_artifacts list_batches list_jobs
list_keys list_materials list_shares list_states list_subjects list_templates list_versions list_webhooks
match_patterns mend_labels query_jobs refine_job retry_job revoke_key revoke_share rotate_key rotate_secret
set_wearing show_batch show_body show_health show_job show_labels show_material show_metrics show_motion show_pattern
show_person show_queue show_readiness show_result show_scan show_subject show_template show_wearer take_message
test_webhook update_subject upload_body upload_labels upload_motion upload_pattern upload_scan
""".split()
"""Ids that generated clients name their functions by: a new route adds one, and none is changed."""

FILES = {"application/octet-stream", *(one.partition(";")[0] for one in MEDIA_TYPES.values())}
BINARY = {"download_artifact": FILES, "download_export": FILES, "download_result": {"application/zip"}}


@pytest.fixture
def page(client) -> dict[str, Any]:
    """Ask the served home for the document."""
    return client.get("/openapi.json").json()


def list_operations(page) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield path, method and description of each route, and of the messages to webhooks."""
    for path, methods in (page["paths"] | page["webhooks"]).items():
        for method, route in methods.items():
            yield path, method, route


def find_values(value: Any, name: str) -> Iterator[Any]:
    """Yield what stands under a name anywhere in the document."""
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        if key == name:
            yield inner
        yield from find_values(inner, name)


def check_by(page, schema: dict[str, Any], value: Any) -> None:
    """Check a value against a schema of the document."""
    whole = {"$ref": "#/checked", "checked": schema, "components": page["components"]}
    Draft202012Validator(whole).validate(value)


def test_the_document_is_valid(page):
    """Broken where a schema is no JSON Schema of OpenAPI 3.1, or names another that is not there."""
    assert page["openapi"].startswith("3.1") and page["servers"]
    assert [error.message for error in OpenAPIV31SpecValidator(page).iter_errors()] == []
    for reference in find_values(page, "$ref"):
        found: Any = page
        assert reference.startswith("#/components/schemas/"), reference
        for word in reference[2:].split("/"):
            found = found[word]
        assert found
    named = {reference.rsplit("/", 1)[1] for reference in find_values(page, "$ref")}
    assert named == set(page["components"]["schemas"]), "each schema is used"


def test_every_example_fits_its_schema(page):
    """Broken where an example shows what the service neither takes nor gives."""
    count = 0
    for path, method, route in list_operations(page):
        contents = [content for answer in route["responses"].values() for content in answer.get("content", {}).values()]
        for content in [*contents, *route.get("requestBody", {}).get("content", {}).values()]:
            assert content["schema"], (path, method)
            if "example" in content:
                check_by(page, content["schema"], content["example"])
                count += 1
        for one in route.get("parameters", ()):
            for example in one["schema"].get("examples", ()):
                check_by(page, one["schema"], example)
    for schema in page["components"]["schemas"].values():
        if "example" in schema:
            check_by(page, schema, schema["example"])
            count += 1
    assert count > 400


def test_operations_have_short_names(page):
    """Broken where a generated client's function is called `upload_scans_v1_scans_post`, or otherwise than before."""
    names = [route["operationId"] for _, _, route in list_operations(page)]
    assert sorted(names) == OPERATIONS
    assert all(re.fullmatch(r"[a-z]+(_[a-z]+)+", name) for name in names)


def test_what_each_answer_is(page):
    """Broken where a route's file, stream or refusal is described as something else, or a refusal is left out."""
    for path, method, route in list_operations(page):
        if path not in page["paths"]:
            continue
        answers, name = route["responses"], route["operationId"]
        good = next(answer for status, answer in sorted(answers.items()) if status < "300")
        media = set(good["content"])
        usual = {"text/plain" if path == "/metrics" else "application/json"}
        assert media == BINARY.get(name, usual) | ({"text/event-stream"} if name == "follow_job" else set())
        for kind in BINARY.get(name, ()):
            assert good["content"][kind]["schema"] == {"type": "string", "format": "binary"}
        refusals = {status: answer for status, answer in answers.items() if status >= "400"}
        assert {"400", "403", "431", "500", "503"} <= set(refusals), (path, method)
        assert not path.startswith("/v1/") or {"401", "404", "413", "422", "429"} <= set(refusals), (path, method)
        assert ("requestBody" in route) <= ("408" in refusals), (path, method)
        for status, answer in refusals.items():
            assert answer["content"].keys() == {"application/problem+json"}, (path, method, status)
            content = answer["content"]["application/problem+json"]
            assert content["schema"] == {"$ref": "#/components/schemas/Problem"}


def test_refusals_are_those_that_are_described(client, database, page):
    """Broken where a refusal comes with a status or a form that the document does not tell."""
    job = ask(client).json()["job"]
    long, odd = {"x-long": "x" * 40_000}, {"content-type": "multipart/form-data"}
    cases = [
        ("get", "/v1/jobs/{job}", "/v1/jobs/deadbeef0000", 404, {}),
        ("get", "/v1/jobs/{job}", f"/v1/jobs/{job}", 431, {"headers": long}),
        ("get", "/healthz", "/healthz", 431, {"headers": long}),
        ("get", "/readyz", "/readyz", 403, {"headers": {"origin": "https://elsewhere.example"}}),
        ("get", "/v1/jobs", "/v1/jobs", 401, {"headers": {"authorization": "Bearer gq_wrong"}}),
        ("post", "/v1/jobs", "/v1/jobs", 422, {"json": {"scan": "x"}}),
        ("post", "/v1/jobs", "/v1/jobs", 413, {"content": b" " * 100_000}),
        ("post", "/v1/scans", "/v1/scans?name=a.ply", 415, {"content": b"x", "headers": odd}),
        ("delete", "/v1/jobs/{job}", f"/v1/jobs/{job}", 409, {}),
    ]  # fmt: skip
    for method, path, url, status, options in cases:
        answer = client.request(method, url, **options)
        assert answer.status_code == status, (url, answer.text)
        ((media, content),) = page["paths"][path][method]["responses"][str(status)]["content"].items()
        assert answer.headers["content-type"] == media
        check_by(page, content["schema"], answer.json())


def test_messages_are_as_described(client, database, queue_job, page):
    """Broken where a webhook gets a message that the document does not tell of."""
    hook, _ = create_webhook(database, "https://93.184.216.34/", (), "")
    fail(database, claim(database, queue_job("one"), "a", 30.0), "scan.x", "bad", bad_input=True)
    cancel(database, queue_job("two"))
    (schema,) = [
        content["schema"] for content in page["webhooks"]["job-ended"]["post"]["requestBody"]["content"].values()
    ]
    queue_trial(database, hook.id)
    seen = set()
    for _ in range(3):
        (message,) = claim_due_messages(database, 1)
        check_by(page, schema, message.body)
        seen.add(message.body["type"])
        with database.write() as session:
            session.query(WebhookRow).update({"taken_until": 0.0})
            session.query(DeliveryRow).filter(DeliveryRow.id == message.id).delete()
    assert seen == {"test", "job.failed", "job.cancelled"}
