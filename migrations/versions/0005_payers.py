"""Keep which API key queued a job last, so that its quota is counted from an index."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Change the tables; a job that several keys own counts for the first of them."""
    op.add_column("jobs", sa.Column("payer", sa.String(length=16), nullable=False, server_default=""))
    op.execute("update jobs set payer = coalesce((select min(key) from owners where owners.job = jobs.id), '')")
    op.create_index("ix_jobs_payer_state", "jobs", ["payer", "state"], unique=False)


def downgrade() -> None:
    """Change them back."""
    op.drop_index("ix_jobs_payer_state", table_name="jobs")
    op.drop_column("jobs", "payer")
