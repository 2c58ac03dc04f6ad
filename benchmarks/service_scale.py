"""A hundred thousand ended jobs of one key: CPU time of lists, filters, sorts, deletions, status and metrics.

    python benchmarks/service_scale.py [--database postgresql] [--jobs 100000]

Times are CPU seconds of this process, which asks the database as the API does; those of a PostgreSQL server are not
counted.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from garmentq.service.batches import find_batch, list_batches
from garmentq.service.database import Database, open_database
from garmentq.service.deletion import delete_jobs
from garmentq.service.garbage import find_all_references
from garmentq.service.job_pages import find_page
from garmentq.service.keys import create_key
from garmentq.service.metrics import prometheus_text
from garmentq.service.models import (
    ArtifactRow,
    BatchRow,
    JobFileRow,
    JobRow,
    JobTagRow,
    MaterialRow,
    MetricRow,
    OwnerRow,
    PatternRow,
    ScanRow,
    SubjectJobRow,
    SubjectRow,
    UploadRow,
)
from garmentq.service.persons import delete_person, delete_subject
from garmentq.service.query import JobQuery, count_states, find_jobs, find_roots, list_jobs, parse_conditions
from garmentq.service.records import ListedJob
from garmentq.service.results import report_jobs
from garmentq.service.retention import find_expired
from garmentq.service.store import Store
from garmentq.service.store_size import sum_store_size
from garmentq.service.subjects import find_subject, list_subjects
from service_load import METRICS, fresh_settings
from sqlalchemy import insert, text

JOBS_AT_ONCE = 2000
FILES_PER_JOB = 8
JOBS_PER_SUBJECT, BATCH_SIZE = 20, 100

GARMENTS = ("skirt", "tshirt", "trousers", "dress")
FABRICS = ("denim", "cotton_poplin", "interlock_knit")

LISTS = (
    ("", "-created"), ("state = failed", "-created"), ("kind = recover", "-created"), ("name = subject7", "-created"),
    ("garment = skirt", "-created"), ("fabric = denim", "-created"), ("method = deform", "-created"),
    ("template = t", "-created"), ("tag != x", "-created"), ("tag = march", "-created"),
    ("subject = subject9", "-created"),
    ("subject = subject9", "name"),
    ("verdict = fail", "-created"),
    ("surface_rms_mm.t2s < 4", "-created"), ("surface_rms_mm.t2s < 0.01", "surface_rms_mm.t2s"),
    ("garment = skirt and surface_rms_mm.t2s < 4", "-created"), ("", "-method"), ("", "error"), ("", "fabric"),
    ("", "name"), ("", "-cpu_seconds"), ("", "hausdorff_mm"), ("", "state"), ("", "finished"),
)  # fmt: skip
"""Conditions and sorts of the command line's reference."""


def fill_table(database: Database, count: int, key: str) -> None:
    """Add ended jobs of a key with results of their usual size, one failed in a hundred."""
    rng = np.random.default_rng(0)
    fabric = dict.fromkeys(("H00", "H01", "H11", "H22", "k", "density", "thickness", "friction"), 1.0)
    with database.write() as session:
        session.execute(
            insert(MaterialRow), [{"id": n, "name": n, "title": "", "sources": [], **fabric} for n in FABRICS]
        )
        people = range(-(-count // JOBS_PER_SUBJECT))
        session.execute(insert(SubjectRow), [describe_subject(number, key) for number in people])
        session.execute(insert(BatchRow), [{"key": key, "tag": tag, "latest": 1.0} for tag in ("march", "april")])
        session.execute(
            insert(BatchRow),
            [{"key": key, "tag": f"batch{n}", "latest": 2.0 + n} for n in range(-(-count // BATCH_SIZE))],
        )
    for begin in range(0, count, JOBS_AT_ONCE):
        numbers = range(begin, min(begin + JOBS_AT_ONCE, count))
        with database.write() as session:
            for table, rows in _describe(numbers, key, rng).items():
                session.execute(insert(table), rows)


def _describe(numbers: range, key: str, rng: np.random.Generator) -> dict[type, list[dict[str, object]]]:
    """Return the rows of some jobs by table."""
    rows: dict[type, list[dict[str, object]]] = {
        table: []
        for table in (
            ScanRow,
            JobRow,
            JobFileRow,
            OwnerRow,
            JobTagRow,
            PatternRow,
            MetricRow,
            ArtifactRow,
            UploadRow,
            SubjectJobRow,
        )
    }
    for n in numbers:
        job, scan, is_failed = f"{n:012x}", f"{n:064x}", n % 100 == 0
        garment, fabric = GARMENTS[n % 4], FABRICS[n % 3]
        subject = f"subject{n // JOBS_PER_SUBJECT}"
        request = {"settings": {"method": "deform", "preset": "default"}, "scan": {"sha256": scan}, "notes": "n" * 500}
        rows[ScanRow].append({"sha256": scan, "name": subject, "size": 1, "created": 0.0, "details": {}})
        rows[UploadRow].append({"key": key, "sha256": scan, "name": f"{subject}.ply", "size": 1, "created": 0.0})
        rows[JobRow].append({
            "id": job, "dedup": scan, "scan": scan, "name": subject, "request": request, "version": "1", "family": job,
            "state": "failed" if is_failed else "succeeded", "touched": 0.0, "created": float(n), "payer": key,
            "started": float(n), "finished": n + 60.0, "result": {"manifest": "m" * 2000, "cpu_seconds": 60.0},
            "error_code": "x.y" if is_failed else None, "verdict": None if is_failed else "pass",
            "method": ("deform", "hybrid")[n % 2], "preset": "default", "garment": garment, "template": "t",
            "fabric": fabric, "body": "builtin", "cpu_seconds": float(rng.random()), "peak_mb": 900.0,
        })  # fmt: skip
        rows[JobFileRow].append({"job": job, "sha256": scan})
        rows[OwnerRow].append({"key": key, "job": job})
        rows[JobTagRow].append({"job": job, "tag": "march" if n % 50 == 0 else "april"})
        rows[JobTagRow].append({"job": job, "tag": f"batch{n // BATCH_SIZE}"})
        rows[SubjectJobRow].append({"job": job, "subject": f"{n // JOBS_PER_SUBJECT:012x}"})
        rows[PatternRow].append(
            {"job": job, "name": "p", "category": garment, "template": "t", "material": fabric, "seams": 1}
        )
        rows[MetricRow] += [{"job": job, "name": name, "value": float(10.0 * rng.random())} for name in METRICS]
        rows[ArtifactRow] += [
            {"job": job, "kind": "result", "name": f"{i}.bin", "sha256": f"{n * FILES_PER_JOB + i:064x}"[::-1],
             "size": 1, "created": 0.0}
            for i in range(FILES_PER_JOB)
        ]  # fmt: skip
    return rows


def describe_subject(number: int, key: str) -> dict[str, object]:
    """Return the row of a subject, every second with a retention that is not over."""
    name, days = f"subject{number}", 36_500.0 if number % 2 else None
    times = {"created": float(number), "consented": 0.0, "consent_until": None, "keep_until": None}
    return {"id": f"{number:012x}", "key": key, "name": name, "note": "", "consent": "", "keep_days": days, **times}


def measure(what: str, ask: Callable[[], object], times: int = 3) -> None:
    """Print the CPU time of asking, the median of some times."""
    spent = []
    for _ in range(times):
        begun = time.process_time()
        ask()
        spent.append(time.process_time() - begun)
    print(f"| {what} | {1e3 * float(np.median(spent)):.0f} |", flush=True)


def main() -> None:
    """Fill a database, and print a table of CPU milliseconds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--database", choices=("sqlite", "postgresql"), default="sqlite")
    parser.add_argument("--jobs", type=int, default=100_000)
    given = parser.parse_args()
    with fresh_settings(given.database) as settings:
        database, store = open_database(settings, is_upgraded=True), Store(settings.store_path)
        store.put_bytes(b"the store is there")
        key = create_key(database, "studio", ("read", "submit"))[0].id
        fill_table(database, given.jobs, key)
        if settings.database_url:
            with database.write() as session:
                session.execute(text("analyze"))
        print(f"| {given.jobs} jobs, {given.database} | CPU ms |\n|---|---|")
        for where, sort in LISTS:
            conditions = parse_conditions(where) if where else []
            measure(
                f"`{where or 'all'}` by `{sort}`",
                lambda asked=conditions, by=sort: report_jobs(
                    database, find_jobs(database, asked, by, 50, key), settings
                ),
            )
        for where, sort in LISTS:
            first = JobQuery(wheres=[where] if where else [], sort=sort, limit=1000)
            page = find_page(database, first, key)
            second = replace(first, cursor=page.next, limit=50)
            measure(
                f"`{where or 'all'}` by `{sort}`: short, with total, after 1000 jobs",
                lambda asked=second: [ListedJob.from_row(row) for row in find_page(database, asked, key).rows],
            )
        measure("page of subjects", lambda: list_subjects(database, key=key))
        measure("a subject of 20 jobs shown", lambda: find_subject(database, "subject9", key))
        measure("page of 50 batches of 100 jobs", lambda: list_batches(database, 50, "", key))
        measure("page of all batches, of an administrator", lambda: list_batches(database, 50))
        measure("a batch of 100 jobs", lambda: find_batch(database, "batch7", key))
        measure("a batch of nearly all jobs", lambda: find_batch(database, "april", key))
        measure("a batch of nearly all jobs, of an administrator", lambda: find_batch(database, "april"))
        kept = replace(settings, keep_days=36_500.0, keep_tag_days="march=36500,april=36500")
        measure("what retention has ended", lambda: find_expired(database, kept))
        measure("all files that rows name", lambda: find_all_references(database))
        measure("page of families", lambda: find_roots(database, (), 50, key))
        measure("status", lambda: (count_states(database), list_jobs(database)))
        measure("metrics", lambda: prometheus_text(database))
        measure("size of the store", lambda: sum_store_size(database))
        last = iter(range(given.jobs - 1, 0, -1))
        measure("a job deleted", lambda: delete_jobs(database, store, [f"{next(last):012x}"], key), 5)
        subject = iter(range(7, 100))
        measure("a person of 20 jobs deleted", lambda: delete_person(database, store, f"subject{next(subject)}", key))
        measure("a subject of 20 jobs deleted", lambda: delete_subject(database, store, f"subject{next(subject)}", key))
        print(f"| peak memory of this process, MB | {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} |")
        database.dispose()


if __name__ == "__main__":
    main()
