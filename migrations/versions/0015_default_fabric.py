"""Say nothing of a fabric where a request of before names the default: that was how one said nothing."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None

DEFAULT = "cotton_poplin"
KINDS = ("recover", "person")
"""Kinds whose requests have settings of a recovery."""

JOBS = sa.table("jobs", sa.column("id", sa.String), sa.column("kind", sa.String), sa.column("request", sa.JSON))


def upgrade() -> None:
    """Change the requests; a job keeps what makes an equal order the same job."""
    _exchange(DEFAULT, None)


def downgrade() -> None:
    """Change them back."""
    _exchange(None, DEFAULT)


def _exchange(before: str | None, after: str | None) -> None:
    """Exchange the fabric of all whose settings have one as it was before."""
    connection = op.get_bind()
    rows = connection.execute(sa.select(JOBS.c.id, JOBS.c.request).where(JOBS.c.kind.in_(KINDS))).all()
    for job, request in rows:
        settings: Any = request.get("settings") if isinstance(request, dict) else None
        if isinstance(settings, dict) and settings.get("fabric", DEFAULT) == before:
            changed = {**request, "settings": {**settings, "fabric": after}}
            connection.execute(sa.update(JOBS).where(JOBS.c.id == job).values(request=changed))
