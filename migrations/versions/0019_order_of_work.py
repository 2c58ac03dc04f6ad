"""Choose jobs by lane and family; let jobs give way."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None

LATEST_FIRST = sa.literal_column("priority DESC")
FAIR_URGENCY = ["state", "queue", LATEST_FIRST, "payer", "created", "id"]
URGENCY = ["state", "queue", "lane", LATEST_FIRST, "payer", "family_created", "created", "id"]
LANES = (("kind", ("edit", "export", "dress", "refit", "outfit"), 0), ("method", ("deform",), 1))
"""Lanes of jobs of before, by a column's values; all others are of the last lane, 2."""
JOBS = sa.table(
    "jobs",
    *(sa.column(name, sa.String) for name in ("id", "family", "kind", "method")),
    *(sa.column(name, sa.Double) for name in ("created", "family_created")),
    sa.column("lane", sa.Integer),
)


def upgrade() -> None:
    """Change the tables, and fill the columns."""
    op.add_column("jobs", sa.Column("lane", sa.Integer(), server_default="2", nullable=False))
    op.add_column("jobs", sa.Column("family_created", sa.Double(), server_default="0", nullable=False))
    op.add_column("jobs", sa.Column("preempt", sa.Boolean(), server_default=sa.false(), nullable=False))
    op.add_column("jobs", sa.Column("preemptions", sa.Integer(), server_default="0", nullable=False))
    root = JOBS.alias("root")
    created = sa.select(root.c.created).where(root.c.id == JOBS.c.family).scalar_subquery()
    connection = op.get_bind()
    connection.execute(sa.update(JOBS).values(family_created=sa.func.coalesce(created, JOBS.c.created)))
    for column, values, lane in reversed(LANES):
        connection.execute(sa.update(JOBS).where(JOBS.c[column].in_(values)).values(lane=lane))
    op.drop_index("ix_jobs_urgency", table_name="jobs")
    op.create_index("ix_jobs_urgency", "jobs", URGENCY, unique=False)


def downgrade() -> None:
    """Change them back."""
    op.drop_index("ix_jobs_urgency", table_name="jobs")
    op.create_index("ix_jobs_urgency", "jobs", FAIR_URGENCY, unique=False)
    with op.batch_alter_table("jobs", schema=None) as batch_op:
        for name in ("lane", "family_created", "preempt", "preemptions"):
            batch_op.drop_column(name)
