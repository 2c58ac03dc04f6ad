"""Keep the subjects of jobs, and when a job with a tag was last ordered."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None

FILL = """
insert into batches (key, tag, latest)
select coalesce(owners.key, ''), job_tags.tag, max(jobs.created)
from job_tags join jobs on jobs.id = job_tags.job left join owners on owners.job = job_tags.job
where jobs.parent is null group by coalesce(owners.key, ''), job_tags.tag
"""
"""A job that no key owns is the local user's."""


def upgrade() -> None:
    """Change the tables, and list the tags of all jobs."""
    op.create_table(
        "subjects",
        sa.Column("id", sa.String(length=16), nullable=False),
        sa.Column("key", sa.String(length=16), nullable=False),
        sa.Column("name", sa.String(length=255), nullable=False),
        sa.Column("note", sa.Text(), nullable=False),
        sa.Column("created", sa.Double(), nullable=False),
        sa.Column("consented", sa.Double(), nullable=True),
        sa.Column("consent", sa.String(length=255), nullable=False),
        sa.Column("consent_until", sa.Double(), nullable=True),
        sa.Column("keep_days", sa.Double(), nullable=True),
        sa.Column("keep_until", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_subjects")),
        sa.UniqueConstraint("key", "name", name=op.f("uq_subjects_key_name")),
    )
    op.create_index("ix_subjects_key_created", "subjects", ["key", "created", "id"], unique=False)
    op.create_index("ix_subjects_created", "subjects", ["created", "id"], unique=False)
    op.create_index("ix_subjects_name", "subjects", ["name"], unique=False)
    op.create_table(
        "subject_jobs",
        sa.Column("job", sa.String(length=16), nullable=False),
        sa.Column("subject", sa.String(length=16), nullable=False),
        sa.ForeignKeyConstraint(["job"], ["jobs.id"], name=op.f("fk_subject_jobs_job_jobs"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(
            ["subject"], ["subjects.id"], name=op.f("fk_subject_jobs_subject_subjects"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("job", name=op.f("pk_subject_jobs")),
    )
    op.create_index("ix_subject_jobs_subject", "subject_jobs", ["subject"], unique=False)
    op.create_table(
        "batches",
        sa.Column("key", sa.String(length=16), nullable=False),
        sa.Column("tag", sa.String(length=64), nullable=False),
        sa.Column("latest", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("key", "tag", name=op.f("pk_batches")),
    )
    op.create_index("ix_batches_key_latest", "batches", ["key", "latest", "tag"], unique=False)
    op.create_index("ix_batches_tag", "batches", ["tag"], unique=False)
    op.execute(FILL)


def downgrade() -> None:
    """Change them back."""
    for name in ("batches", "subject_jobs", "subjects"):
        op.drop_table(name)
