"""Keep imported fabrics."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Change the tables."""
    op.create_table(
        "fabrics",
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("fabric", sa.JSON(none_as_null=True), nullable=False),
        sa.Column("created", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_fabrics")),
    )


def downgrade() -> None:
    """Change them back."""
    op.drop_table("fabrics")
