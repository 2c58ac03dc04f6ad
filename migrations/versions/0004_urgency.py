"""Let the most urgent queued job be the first entry of an index, so that claiming it reads one row of any queue."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Change the indexes."""
    op.create_index(
        "ix_jobs_urgency", "jobs", ["state", "queue", sa.literal_column("priority DESC"), "created", "id"], unique=False
    )
    op.drop_index("ix_jobs_state_queue_priority_created", table_name="jobs")


def downgrade() -> None:
    """Change them back."""
    op.create_index(
        "ix_jobs_state_queue_priority_created", "jobs", ["state", "queue", "priority", "created"], unique=False
    )
    op.drop_index("ix_jobs_urgency", table_name="jobs")
