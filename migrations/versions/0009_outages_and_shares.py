"""Let jobs rest while something is away, share workers between keys, and keep a log of what keys do."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None

URGENCY = ["state", "queue", sa.literal_column("priority DESC"), "created", "id"]
FAIR_URGENCY = ["state", "queue", sa.literal_column("priority DESC"), "payer", "created", "id"]


def upgrade() -> None:
    """Change the tables; columns are only added, so that SQLite need not copy any."""
    op.add_column("jobs", sa.Column("delays", sa.Integer(), nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("delay_code", sa.String(length=64), nullable=True))
    op.add_column("jobs", sa.Column("not_before", sa.Double(), nullable=True))
    op.drop_index("ix_jobs_urgency", table_name="jobs")
    op.create_index("ix_jobs_urgency", "jobs", FAIR_URGENCY, unique=False)
    op.add_column("api_keys", sa.Column("priority", sa.Integer(), nullable=False, server_default="0"))
    op.add_column("api_keys", sa.Column("expires", sa.Double(), nullable=True))
    op.add_column("api_keys", sa.Column("used", sa.Double(), nullable=True))
    op.add_column("uploads", sa.Column("kinds", sa.JSON(none_as_null=True), nullable=False, server_default="[]"))
    op.create_table(
        "outages",
        sa.Column("place", sa.String(length=255), nullable=False),
        sa.Column("code", sa.String(length=64), nullable=False),
        sa.Column("since", sa.Double(), nullable=False),
        sa.Column("seen", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("place", "code", name=op.f("pk_outages")),
    )
    op.create_table(
        "payers",
        sa.Column("payer", sa.String(length=16), nullable=False),
        sa.Column("served", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("payer", name=op.f("pk_payers")),
    )
    op.create_table(
        "audit",
        sa.Column("id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), autoincrement=True, nullable=False),
        sa.Column("at", sa.Double(), nullable=False),
        sa.Column("key", sa.String(length=16), nullable=False),
        sa.Column("action", sa.String(length=32), nullable=False),
        sa.Column("subject", sa.String(length=255), nullable=False),
        sa.Column("address", sa.String(length=64), nullable=False),
        sa.Column("request", sa.String(length=64), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_audit")),
    )
    op.create_index(op.f("ix_audit_at"), "audit", ["at"], unique=False)


def downgrade() -> None:
    """Change them back."""
    for table in ("audit", "payers", "outages"):
        op.drop_table(table)
    op.drop_index("ix_jobs_urgency", table_name="jobs")
    for table, columns in {
        "jobs": ("not_before", "delay_code", "delays"),
        "api_keys": ("used", "expires", "priority"),
        "uploads": ("kinds",),
    }.items():
        with op.batch_alter_table(table, schema=None) as batch_op:
            for column in columns:
                batch_op.drop_column(column)
    op.create_index("ix_jobs_urgency", "jobs", URGENCY, unique=False)
