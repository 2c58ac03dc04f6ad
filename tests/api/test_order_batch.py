"""Many orders in one request: each is queued or refused by itself, and a repeated request queues none twice."""

from __future__ import annotations

import asyncio

import pytest
from api_work import ask, code_of, make_key, make_ply, upload
from garmentq.core.run.errors import GarmentqError
from garmentq.service.async_client import AsyncClient
from garmentq.service.client import Client
from garmentq.service.job_handle import JobHandle

BODY = "builtin:female,height=1.70"


def order(client, *orders, **headers):
    """Send orders."""
    return client.post("/v1/jobs/batch", json={"orders": list(orders)}, headers=headers)


def test_each_order_has_its_result(client):
    """Broken where one bad order keeps the others from being queued, or the results are in another order."""
    scans = [upload(client, 0.1 * n) for n in range(3)]
    done = ask(client, 0.9).json()["job"]
    answer = order(
        client,
        {"scan": scans[0], "body": BODY, "tags": ["march"]}, {"scan": "0" * 64, "body": BODY},
        {"scan": scans[1], "body": BODY}, {"scan": scans[2], "body": "builtin:nosuch"},
        {"kind": "export", "result": done, "options": {"format": "pdf"}},
        {"scan": scans[2], "body": BODY, "check": True},
    )  # fmt: skip
    results = answer.json()["results"]
    codes = [one["error"] and (one["error"]["status"], one["error"]["code"]) for one in results]
    refused = [(404, "upload.unknown"), (422, "body.spec_bad"), (422, "job.input_not_ended"), (422, "request.bad")]
    assert answer.status_code == 200 and codes == [None, refused[0], None, *refused[1:]]
    jobs = [one["job"]["job"] for one in results if one["job"]]
    assert all(client.get(f"/v1/jobs/{job}").json()["state"] == "queued" for job in jobs)
    assert client.get(f"/v1/jobs/{jobs[0]}").json()["tags"] == ["march"]
    assert [one["job"]["is_new"] for one in order(client, {"scan": scans[1], "body": BODY}).json()["results"]] == [
        False
    ]


def test_a_repeated_request_queues_none_twice(client):
    """Broken where forced jobs are queued again after a lost answer, or another order is taken for the first."""
    orders = [{"scan": upload(client, 0.1 * n), "body": BODY, "force": True} for n in range(2)]
    token = {"idempotency-key": "a" * 120}
    first, again = (order(client, *orders, **token).json()["results"] for _ in range(2))
    assert [one["job"]["job"] for one in first] == [one["job"]["job"] for one in again]
    assert [one["job"]["is_new"] for one in again] == [False, False]
    swapped = order(client, *orders[::-1], **token).json()["results"]
    assert [one["error"]["code"] for one in swapped] == ["request.idempotency_mismatch"] * 2
    assert client.get("/v1/jobs").json()["total"] == 2


@pytest.mark.parametrize("orders", [[], [{"scan": "0" * 64}] * 101, [{"scan": "0" * 64, "bodyy": "x"}], {"scan": 1}])
def test_the_request_is_bounded(client, orders):
    """Broken where any number of orders is taken, or a misspelt field is left out."""
    assert code_of(client.post("/v1/jobs/batch", json={"orders": orders})) == "request.bad"


def test_a_hundred_orders_fit(client):
    """Broken where the body of a hundred orders with long names is larger than what is taken."""
    orders = [{"scan": "0" * 64, "name": "n" * 250, "tags": ["t" * 64] * 20, "settings": {}} for _ in range(100)]
    answer = order(client, *orders)
    assert answer.status_code == 200 and len(answer.json()["results"]) == 100


def test_a_key_has_its_limits(client, database):
    """Broken where a key queues more than its quota, of a higher priority, or without the scope."""
    small, reader = make_key(database, "small", quota=1), make_key(database, "reader", "read")
    scans = [upload(client, 0.1 * n, headers=small) for n in range(3)]
    payload = {"orders": [{"scan": scan, "body": BODY} for scan in scans]}
    payload["orders"][0]["priority"] = 5
    results = client.post("/v1/jobs/batch", json=payload, headers=small).json()["results"]
    assert [one["error"] and one["error"]["code"] for one in results] == ["key.priority", None, "key.queue_full"]
    assert code_of(client.post("/v1/jobs/batch", json=payload, headers=reader)) == "key.scope_missing"


def test_a_program_queues_many(client, address, tmp_path):
    """Broken where the client raises for one bad file, or returns another scan's job in its place."""
    for n in range(3):
        (tmp_path / f"scan{n}.ply").write_bytes(make_ply(0.1 * n))
    scans = [tmp_path / name for name in ("scan0.ply", "nosuch.ply", "scan1.ply", "scan2.ply")]
    token = client.headers["authorization"].removeprefix("Bearer ")
    with Client(address, token) as service:
        found = service.recover_many(scans, BODY, tags=["march"], given_as="garment")
    assert [isinstance(one, GarmentqError) for one in found] == [False, True, False, False]
    assert [one.name for one in found if isinstance(one, JobHandle)] == ["scan0", "scan1", "scan2"]

    async def queue_again():
        async with AsyncClient(address, token) as service:
            return await service.recover_many(scans[2:], BODY, tags=["march"], given_as="garment")

    assert [one.id for one in asyncio.run(queue_again())] == [one.id for one in found[2:]]
