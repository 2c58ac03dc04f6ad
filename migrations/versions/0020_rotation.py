"""Keep the secret of a webhook and the token of a key beside their successors for a time."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns."""
    op.add_column("webhooks", sa.Column("earlier_secret", sa.String(length=64), nullable=True))
    op.add_column("webhooks", sa.Column("earlier_until", sa.Double(), nullable=True))
    op.add_column("api_keys", sa.Column("earlier_hash", sa.String(length=64), nullable=True))
    op.add_column("api_keys", sa.Column("earlier_until", sa.Double(), nullable=True))
    op.create_index(op.f("ix_api_keys_earlier_hash"), "api_keys", ["earlier_hash"])


def downgrade() -> None:
    """Remove them; the newest secrets and tokens stay valid."""
    op.drop_index(op.f("ix_api_keys_earlier_hash"), table_name="api_keys")
    for table, names in (
        ("api_keys", ("earlier_hash", "earlier_until")),
        ("webhooks", ("earlier_secret", "earlier_until")),
    ):
        with op.batch_alter_table(table, schema=None) as batch_op:
            for name in names:
                batch_op.drop_column(name)
