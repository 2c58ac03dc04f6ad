"""Return each job a queue, and keep which workers are alive."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Change the tables."""
    op.create_table(
        "workers",
        sa.Column("name", sa.String(length=255), nullable=False),
        sa.Column("queues", sa.String(length=64), nullable=False),
        sa.Column("concurrency", sa.Integer(), nullable=False),
        sa.Column("started", sa.Double(), nullable=False),
        sa.Column("seen", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_workers")),
    )
    with op.batch_alter_table("jobs", schema=None) as batch_op:
        batch_op.add_column(sa.Column("queue", sa.String(length=16), nullable=False, server_default="cpu"))
        batch_op.create_index(
            "ix_jobs_state_queue_priority_created", ["state", "queue", "priority", "created"], unique=False
        )
        batch_op.drop_index("ix_jobs_state_priority_created")


def downgrade() -> None:
    """Change them back."""
    with op.batch_alter_table("jobs", schema=None) as batch_op:
        batch_op.create_index("ix_jobs_state_priority_created", ["state", "priority", "created"], unique=False)
        batch_op.drop_index("ix_jobs_state_queue_priority_created")
        batch_op.drop_column("queue")
    op.drop_table("workers")
