"""What a monitor reads: right numbers, whatever the database, and as many lines however much there is."""

from __future__ import annotations

import re
from collections import Counter
from contextlib import closing

import httpx
import pytest
from api_client import serving
from garmentq.service.api.request_times import LATENCY_BOUNDS, RequestTimes, RouteClass, classify
from garmentq.service.database import clock
from garmentq.service.jobs import claim
from garmentq.service.keys import create_key
from garmentq.service.metrics import prometheus_text
from garmentq.service.models import ArtifactRow, DeliveryRow, JobRow, OutageRow, UploadRow, WebhookRow
from garmentq.service.outage import STALE_SECONDS, note_outage
from garmentq.service.store_size import sum_store_size
from garmentq_home import wait_for
from sqlalchemy import update

LINE = re.compile(r'(garmentq_[a-z0-9_]+)(\{(?:[a-z]+="[^"\n]*",?)+\})? (-?[0-9.e+-]+|nan|inf)')


def parse(text: str) -> dict[str, float]:
    """Return every value by name and labels; each line is a comment or a value of a metric that was declared."""
    values: dict[str, float] = {}
    kinds = dict(re.findall(r"^# TYPE (\S+) (\S+)$", text, re.MULTILINE))
    assert set(kinds) == set(re.findall(r"^# HELP (\S+) .+$", text, re.MULTILINE))
    for line in text.splitlines():
        if not line.startswith("#"):
            name, labels, value = LINE.fullmatch(line).groups()
            base = re.sub("_(bucket|sum|count)$", "", name) if name not in kinds else name
            assert kinds[base] in ("counter", "gauge", "histogram") and name + (labels or "") not in values
            values[name.removeprefix("garmentq_") + (labels or "")] = float(value)
    return values


def test_ages_outages_and_messages(database, queue_job):
    """Broken where a job that hangs, a full store or a webhook that is away looks like a quiet service."""
    quiet = parse(prometheus_text(database))
    for name in ("running_age_seconds", "webhook_messages", "webhook_age_seconds", 'outages{code="store.full"}'):
        assert quiet[name] == 0.0, name
    long, short, waiting = (queue_job(name) for name in ("long", "short", "waiting"))
    for job, age in ((long, 700.0), (short, 5.0)):
        claim(database, job, "a", 30.0)
        with database.write() as session:
            session.execute(update(JobRow).where(JobRow.id == job).values(started=clock() - age))
    with database.write() as session:
        session.execute(update(JobRow).where(JobRow.id == waiting).values(created=clock() - 90.0))
        session.add(WebhookRow(id="w", key="", url="http://x", secret="s", states=[], created=0.0))
        session.flush()
        for number, (due, age) in enumerate([(0.0, 40.0), (0.0, 20.0), (None, 9000.0)]):
            row = DeliveryRow(id=str(number), webhook="w", job=None, body={}, created=clock() - age, due=due)
            session.add(row)
        session.add(OutageRow(place="old", code="store.full", since=clock(), seen=clock() - STALE_SECONDS - 1.0))
    for place in ("one", "two"):
        note_outage(database, place, "store.full")
    now = parse(prometheus_text(database))
    assert now["running_age_seconds"] == pytest.approx(700.0, abs=60.0)
    assert now['queue_age_seconds{queue="cpu"}'] == pytest.approx(90.0, abs=60.0)
    assert now["webhook_messages"] == 2.0 and now["webhook_age_seconds"] == pytest.approx(40.0, abs=15.0)
    assert now['outages{code="store.full"}'] == 2.0 and now['outages{code="store.unreachable"}'] == 0.0
    assert set(now) == set(quiet), "no line comes with jobs, hosts or webhooks"


def test_the_size_of_the_store_counts_each_file_once(database, queue_job):
    """Broken where shared files are counted for each job, or an upload without a job is free."""
    first, second = queue_job("first"), queue_job("second")
    scans = sum_store_size(database)
    with database.write() as session:
        for job, key, size in ((first, "a", 1000), (second, "a", 1000), (second, "b", 1 << 40)):
            session.add(ArtifactRow(job=job, kind="result", name=key, sha256=key * 64, size=size, created=0.0))
        session.add(UploadRow(key="k", sha256="c" * 64, name="c", size=7, created=0.0))
        session.add(UploadRow(key="l", sha256="c" * 64, name="c", size=7, created=0.0))
    assert scans > 0 and sum_store_size(database) == scans + 1000 + (1 << 40) + 7


def test_each_request_is_counted_once_in_a_bounded_number_of_lines(settings, database):
    """Broken where lines grow with keys and paths, a refusal or a fault is not counted, or buckets do not add up."""
    tokens = [create_key(database, str(number), ("metrics", "read"))[1] for number in range(4)]
    with serving(settings, is_open=False) as url, closing(httpx.Client(base_url=url)) as client:

        def scrape() -> dict[str, float]:
            return parse(client.get("/metrics", headers={"authorization": f"Bearer {tokens[0]}"}).text)

        scrape()
        wait_for(lambda: "store_bytes" in scrape())
        before = scrape()
        assert before["store_bytes"] == sum_store_size(database) and before["store_free_bytes"] > 0
        paths = [
            ("GET", "/v1/jobs"), ("GET", "/v1/queue"), ("GET", "/v1/jobs/abcdef012345"), ("POST", "/v1/jobs"),
            ("GET", "/v1/jobs/abcdef/artifacts/x"), ("GET", "/v1/jobs/abcdef/events"), ("POST", "/v1/scans"),
            ("GET", "/healthz"), ("GET", "/nowhere"), ("GET", "/x" * 300), ("DELETE", "/v1/keys/x"), ("PATCH", "/v1/x"),
        ]  # fmt: skip
        answers = Counter()
        for token in tokens:
            for method, path in paths:
                answer = client.request(method, path, headers={"authorization": f"Bearer {token}"})
                answers[
                    f'api_responses_total{{route="{classify(method, path)}",status="{answer.status_code // 100}xx"}}'
                ] += 1
        after = scrape()
    assert set(after) == set(before)
    answers['api_responses_total{route="monitoring",status="2xx"}'] += 1  # the scrape before
    changed = {name: after[name] - before[name] for name in after if name.startswith("api_responses")}
    assert {name: count for name, count in changed.items() if count} == answers
    for route in RouteClass:
        buckets = [
            after[f'api_request_seconds_bucket{{route="{route}",le="{le}"}}'] for le in (*LATENCY_BOUNDS, "+Inf")
        ]
        assert buckets == sorted(buckets) and buckets[-1] == after[f'api_request_seconds_count{{route="{route}"}}']
        assert buckets[-1] == sum(after[f'api_responses_total{{route="{route}",status="{n}xx"}}'] for n in (2, 3, 4, 5))


def test_the_histogram_of_known_times():
    """Broken where a time falls into the bucket beside its own, or the sum is not that of the times."""
    times = RequestTimes()
    for seconds in (0.005, 0.0051, 0.3, 1e6):
        times.note(RouteClass.READ, 200, seconds)
    times.note(RouteClass.READ, 503, 0.02)
    values = parse(times.format_metrics())
    found = {le: values[f'api_request_seconds_bucket{{route="read",le="{le}"}}'] for le in (*LATENCY_BOUNDS, "+Inf")}
    assert [found[le] for le in (0.005, 0.01, 0.025, 0.25, 0.5, 120.0, "+Inf")] == [1, 2, 3, 3, 4, 4, 5]
    assert values['api_request_seconds_sum{route="read"}'] == pytest.approx(0.005 + 0.0051 + 0.3 + 1e6 + 0.02)
    assert values['api_responses_total{route="read",status="5xx"}'] == 1.0


def test_a_fault_is_a_5xx():
    """Broken where a route that raises is not an error to whoever watches."""
    import asyncio

    from garmentq.service.api.request_times import RequestTimer

    async def fail(scope, receive, send):
        raise RuntimeError("planted")

    times = RequestTimes()
    with pytest.raises(RuntimeError):
        asyncio.run(RequestTimer(fail, times)({"type": "http", "method": "GET", "path": "/v1/jobs"}, None, None))
    assert parse(times.format_metrics())['api_responses_total{route="read",status="5xx"}'] == 1.0
