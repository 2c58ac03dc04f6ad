"""Keep how far a job is in all, and when it should end."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Change the tables; columns are only added."""
    op.add_column("jobs", sa.Column("overall", sa.Double(), nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("expected_end", sa.Double(), nullable=True))


def downgrade() -> None:
    """Change them back."""
    with op.batch_alter_table("jobs", schema=None) as batch_op:
        batch_op.drop_column("expected_end")
        batch_op.drop_column("overall")
