"""Add a kind and a family to each job: a parent, results that it reads, siblings that it waits for, tags."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Change the tables; every job so far recovers a garment, and is a family of its own.

    Columns are only added, so that SQLite need not copy the table: dropping the old one would take its events along.
    """
    op.add_column("jobs", sa.Column("kind", sa.String(length=32), nullable=False, server_default="recover"))
    op.execute("alter table jobs add column parent varchar(16) constraint fk_jobs_parent references jobs (id)")
    op.add_column("jobs", sa.Column("family", sa.String(length=16), nullable=False, server_default=""))
    op.execute("update jobs set family = id")
    op.add_column("jobs", sa.Column("checked", sa.JSON(none_as_null=True), nullable=True))
    op.create_index("ix_jobs_family", "jobs", ["family"], unique=False)
    op.create_index("ix_jobs_parent", "jobs", ["parent"], unique=False)
    op.create_table(
        "job_inputs",
        sa.Column("job", sa.String(length=16), nullable=False),
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("input", sa.String(length=16), nullable=False),
        sa.ForeignKeyConstraint(["job"], ["jobs.id"], name=op.f("fk_job_inputs_job"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(["input"], ["jobs.id"], name=op.f("fk_job_inputs_input")),
        sa.PrimaryKeyConstraint("job", "name", name=op.f("pk_job_inputs")),
    )
    op.create_index(op.f("ix_job_inputs_input"), "job_inputs", ["input"], unique=False)
    op.create_table(
        "job_waits",
        sa.Column("job", sa.String(length=16), nullable=False),
        sa.Column("awaited", sa.String(length=16), nullable=False),
        sa.ForeignKeyConstraint(["job"], ["jobs.id"], name=op.f("fk_job_waits_job"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(["awaited"], ["jobs.id"], name=op.f("fk_job_waits_awaited")),
        sa.PrimaryKeyConstraint("job", "awaited", name=op.f("pk_job_waits")),
    )
    op.create_index(op.f("ix_job_waits_awaited"), "job_waits", ["awaited"], unique=False)
    op.create_table(
        "job_tags",
        sa.Column("job", sa.String(length=16), nullable=False),
        sa.Column("tag", sa.String(length=64), nullable=False),
        sa.ForeignKeyConstraint(["job"], ["jobs.id"], name=op.f("fk_job_tags_job"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("job", "tag", name=op.f("pk_job_tags")),
    )
    op.create_index(op.f("ix_job_tags_tag"), "job_tags", ["tag"], unique=False)


def downgrade() -> None:
    """Change them back; SQLite must not enforce foreign keys meanwhile, or the copied table's events go with it."""
    for table in ("job_tags", "job_waits", "job_inputs"):
        op.drop_table(table)
    for name in ("ix_jobs_parent", "ix_jobs_family", "ix_jobs_urgency"):
        op.drop_index(name, table_name="jobs")
    with op.batch_alter_table("jobs", schema=None) as batch_op:
        for column in ("checked", "family", "parent", "kind"):
            batch_op.drop_column(column)
    op.create_index(
        "ix_jobs_urgency", "jobs", ["state", "queue", sa.literal_column("priority DESC"), "created", "id"], unique=False
    )
