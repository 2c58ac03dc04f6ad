"""Keep the verdict on a job's result, and say `doubtful` where a gate said `warn`."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None

ORDER = ("pass", "doubtful", "fail")
"""Verdicts from best to worst."""

jobs = sa.table(
    "jobs", sa.column("id", sa.String), sa.column("verdict", sa.String), sa.column("result", sa.JSON(none_as_null=True))
)


def upgrade() -> None:
    """Change the tables; a job that has gates gets the worst of their verdicts."""
    op.add_column("jobs", sa.Column("verdict", sa.String(length=16), nullable=True))
    op.create_index("ix_jobs_verdict", "jobs", ["verdict"], unique=False)
    _rename("warn", "doubtful", has_column=True)


def downgrade() -> None:
    """Change them back."""
    _rename("doubtful", "warn", has_column=False)
    op.drop_index("ix_jobs_verdict", table_name="jobs")
    op.drop_column("jobs", "verdict")


def _rename(old: str, new: str, has_column: bool) -> None:
    """Rename a verdict in every result, and with `has_column` fill the column of those that have gates."""
    connection = op.get_bind()
    for job, result in connection.execute(sa.select(jobs.c.id, jobs.c.result)).all():
        gates: list[dict[str, Any]] = (result or {}).get("gates", [])
        if not gates:
            continue
        renamed = [{**gate, "verdict": new if gate["verdict"] == old else gate["verdict"]} for gate in gates]
        values: dict[str, Any] = {"result": {**result, "gates": renamed}}
        if has_column:
            values["verdict"] = max((gate["verdict"] for gate in renamed), key=ORDER.index)
        connection.execute(jobs.update().where(jobs.c.id == job).values(**values))
