"""Let a webhook be owed a message that is about no job, and keep what came of each message."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Change the tables."""
    with op.batch_alter_table("deliveries", schema=None) as batch_op:
        batch_op.alter_column("job", existing_type=sa.String(length=16), nullable=True)
        batch_op.add_column(sa.Column("status", sa.Integer(), nullable=True))
        batch_op.add_column(sa.Column("error", sa.String(length=255), nullable=True))


def downgrade() -> None:
    """Change them back; what is about no job goes."""
    op.execute(sa.text("delete from deliveries where job is null"))
    with op.batch_alter_table("deliveries", schema=None) as batch_op:
        batch_op.drop_column("error")
        batch_op.drop_column("status")
        batch_op.alter_column("job", existing_type=sa.String(length=16), nullable=False)
