"""Keep what lists are sorted and filtered by in the jobs' own columns, with indexes; name the files of requests."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None

LISTED = (
    "name", "kind", "state", "version", "error_code", "verdict", "garment", "template", "fabric", "body", "method",
    "preset", "started", "finished", "attempts", "priority", "cpu_seconds", "peak_mb",
)  # fmt: skip
TEXTS = {"method": 32, "preset": 32, "garment": 32, "template": 255, "fabric": 64, "body": 255}
COSTS = ("cpu_seconds", "peak_mb")
HASH = re.compile(r"[0-9a-f]{64}")
ROWS_AT_ONCE = 500

JOBS = sa.table(
    "jobs",
    *(sa.column(name, sa.String) for name in ("id", *TEXTS)),
    *(sa.column(name, sa.Double) for name in COSTS),
    sa.column("request", sa.JSON(none_as_null=True)),
    sa.column("result", sa.JSON(none_as_null=True)),
)
FILES = sa.table("job_files", sa.column("job", sa.String), sa.column("sha256", sa.String))
PATTERNS = sa.table("patterns", *(sa.column(name, sa.String) for name in ("job", "category", "template", "material")))
MATERIALS = sa.table("materials", sa.column("id", sa.String), sa.column("name", sa.String))
BODIES = sa.table("bodies", sa.column("job", sa.String), sa.column("source", sa.String))


def upgrade() -> None:
    """Change the tables, and fill the columns from requests and results."""
    for name, length in TEXTS.items():
        op.add_column("jobs", sa.Column(name, sa.String(length=length), nullable=True))
    for name in COSTS:
        op.add_column("jobs", sa.Column(name, sa.Double(), nullable=True))
    op.create_table(
        "job_files",
        sa.Column("job", sa.String(length=16), nullable=False),
        sa.Column("sha256", sa.String(length=64), nullable=False),
        sa.ForeignKeyConstraint(["job"], ["jobs.id"], name=op.f("fk_job_files_job_jobs"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("job", "sha256", name=op.f("pk_job_files")),
    )
    op.create_table(
        "event_counts",
        sa.Column("kind", sa.String(length=32), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("kind", name=op.f("pk_event_counts")),
    )
    _fill(op.get_bind())
    for name in ("verdict", "parent"):
        op.drop_index(f"ix_jobs_{name}", table_name="jobs")
    op.create_index("ix_jobs_parent_created", "jobs", ["parent", "created", "id"], unique=False)
    op.create_index("ix_jobs_state_finished", "jobs", ["state", "finished"], unique=False)
    for name in LISTED:
        op.create_index(f"ix_jobs_{name}_created", "jobs", [name, "created", "id"], unique=False)
    op.create_index("ix_job_files_sha256", "job_files", ["sha256"], unique=False)
    op.create_index("ix_uploads_sha256", "uploads", ["sha256"], unique=False)
    op.create_index("ix_owners_job", "owners", ["job"], unique=False)


def downgrade() -> None:
    """Change them back."""
    op.drop_index("ix_owners_job", table_name="owners")
    op.drop_index("ix_uploads_sha256", table_name="uploads")
    for name in LISTED:
        op.drop_index(f"ix_jobs_{name}_created", table_name="jobs")
    for name in ("parent_created", "state_finished"):
        op.drop_index(f"ix_jobs_{name}", table_name="jobs")
    for name in ("verdict", "parent"):
        op.create_index(f"ix_jobs_{name}", "jobs", [name], unique=False)
    op.drop_table("event_counts")
    op.drop_table("job_files")
    with op.batch_alter_table("jobs", schema=None) as batch_op:
        for name in (*TEXTS, *COSTS):
            batch_op.drop_column(name)


def _fill(connection: sa.Connection) -> None:
    """Fill the columns of jobs and the table of files; the jobs are read some at a time."""
    is_of = PATTERNS.c.job == JOBS.c.id
    for name in ("category", "template"):
        value = sa.select(PATTERNS.c[name]).where(is_of).scalar_subquery()
        connection.execute(sa.update(JOBS).values({"garment" if name == "category" else name: value}))
    fabric = sa.select(MATERIALS.c.name).where(is_of, PATTERNS.c.material == MATERIALS.c.id).scalar_subquery()
    body = sa.select(BODIES.c.source).where(BODIES.c.job == JOBS.c.id).scalar_subquery()
    connection.execute(sa.update(JOBS).values(fabric=fabric, body=body))
    last = ""
    while True:
        rows = connection.execute(
            sa.select(JOBS.c.id, JOBS.c.request, JOBS.c.result)
            .where(JOBS.c.id > last)
            .order_by(JOBS.c.id)
            .limit(ROWS_AT_ONCE)
        ).all()
        if not rows:
            return
        last = rows[-1].id
        files = [{"job": row.id, "sha256": key} for row in rows for key in sorted(set(_find_hashes(row.request)))]
        if files:
            connection.execute(sa.insert(FILES), files)
        for row in rows:
            values = {**_read(row.request, "settings", ("method", "preset"), str), **_read_costs(row.result)}
            connection.execute(sa.update(JOBS).where(JOBS.c.id == row.id).values(values))


def _read(request: Any, part: str, names: tuple[str, ...], kind: type) -> dict[str, Any]:
    """Return some values of a part of a request, None where they are absent or of another type."""
    found = request.get(part) if isinstance(request, dict) else None
    values = found if isinstance(found, dict) else {}
    return {name: values[name] if isinstance(values.get(name), kind) else None for name in names}


def _read_costs(result: Any) -> dict[str, float | None]:
    """Return a result's cost."""
    values = result if isinstance(result, dict) else {}
    return {name: float(values[name]) if isinstance(values.get(name), int | float) else None for name in COSTS}


def _find_hashes(value: Any) -> Iterator[str]:
    """Yield every key of a stored file that a request's JSON values name."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
            yield from _find_hashes(part)
    elif isinstance(value, str) and HASH.fullmatch(value):
        yield value
