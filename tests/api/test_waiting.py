"""A request that waits for a job's end: it returns then, holds no thread, and ends with its client."""

from __future__ import annotations

import asyncio
import threading

import httpx
import pytest
from api_client import LIMITS, local_user, serving
from api_work import ask, code_of, finish
from garmentq.service.api.limits import ApiLimits
from garmentq.service.client import Client
from garmentq_home import wait_for


def test_it_returns_with_the_end(client, settings, database, store, tmp_path):
    """Broken where the answer comes before the job has ended, or lacks its result."""
    job = ask(client).json()["job"]
    assert client.get(f"/v1/jobs/{job}", params={"wait": 0.2}).json()["state"] == "queued"
    ender = threading.Timer(0.3, finish, (settings, database, store, job, tmp_path / "files"))
    ender.start()
    found = client.get(f"/v1/jobs/{job}", params={"wait": 60}).json()
    ender.join()
    assert found["state"] == "succeeded" and found == client.get(f"/v1/jobs/{job}", params={"wait": 60}).json()
    assert code_of(client.get("/v1/jobs/deadbeef0000", params={"wait": 60})) == "job.unknown"


@pytest.mark.parametrize("seconds", ["-1", "60.1", "nan", "inf", "x"])
def test_the_wait_is_bounded(client, seconds):
    """Broken where a request may stay for ever."""
    job = ask(client).json()["job"]
    assert code_of(client.get(f"/v1/jobs/{job}", params={"wait": seconds})) == "request.bad"


def test_a_deleted_job_is_no_longer_waited_for(client):
    """Broken where a request waits for a job that is gone."""
    job = ask(client).json()["job"]
    client.post(f"/v1/jobs/{job}/cancel")
    remover = threading.Timer(0.3, client.delete, (f"/v1/jobs/{job}",))
    remover.start()
    found = client.get(f"/v1/jobs/{job}", params={"wait": 60})
    remover.join()
    assert found.json()["state"] == "cancelled"
    assert code_of(client.get(f"/v1/jobs/{job}", params={"wait": 60})) == "job.unknown"


def test_a_wait_ends_with_its_client(client, address, settings):
    """Broken where clients that left still count, so that the key may wait no more (it may have two)."""
    job = ask(client).json()["job"]
    for _ in range(LIMITS.streams + 1):
        with (
            httpx.Client(base_url=address, timeout=0.3, headers=local_user(settings)) as left,
            pytest.raises(httpx.TimeoutException),
        ):
            left.get(f"/v1/jobs/{job}", params={"wait": 60})
        wait_for(lambda: client.get(f"/v1/jobs/{job}", params={"wait": 0.01}).status_code == 200)


def test_many_may_wait(settings, database):
    """Broken where each waiting request holds one of the forty threads, and no other is answered."""
    with serving(settings, ApiLimits(streams=100)) as url:
        with httpx.Client(base_url=url, headers=local_user(settings)) as client:
            job = ask(client).json()["job"]

            async def wait_all() -> list[str]:
                limits = httpx.Limits(max_connections=60)
                async with httpx.AsyncClient(
                    base_url=url, headers=local_user(settings), limits=limits, timeout=100.0
                ) as many:
                    waits = [asyncio.create_task(many.get(f"/v1/jobs/{job}", params={"wait": 60})) for _ in range(45)]
                    await asyncio.sleep(1.0)
                    assert not any(one.done() for one in waits)
                    assert (await many.get("/v1/queue")).status_code == 200
                    await many.post(f"/v1/jobs/{job}/cancel")
                    return [one.json()["state"] for one in await asyncio.gather(*waits)]

            assert asyncio.run(wait_all()) == ["cancelled"] * 45


def test_a_program_waits_by_it(client, address, settings, database, store, tmp_path):
    """Broken where a program that waits for more jobs than its key has streams fails, or goes on before the end."""
    jobs = [ask(client, 0.1 * n).json()["job"] for n in range(LIMITS.streams + 2)]
    token = local_user(settings)["authorization"].removeprefix("Bearer ")
    services = [Client(address, token) for _ in jobs]
    handles = [service.job(job) for service, job in zip(services, jobs, strict=True)]
    threads = [threading.Thread(target=handle.wait, args=(60.0,)) for handle in handles]
    for thread in threads:
        thread.start()
    for n, job in enumerate(jobs):
        finish(settings, database, store, job, tmp_path / str(n))
    for thread in threads:
        thread.join()
    assert [handle.state for handle in handles] == ["succeeded"] * len(jobs)
    for service in services:
        service.close()
