"""Run the migrations on the connection that the service hands over."""

from __future__ import annotations

from alembic import context
from garmentq.service.models import Base


def run() -> None:
    """Run within the caller's transaction; batch mode lets SQLite alter its tables."""
    connection = context.config.attributes["connection"]
    context.configure(
        connection=connection,
        target_metadata=Base.metadata,
        render_as_batch=True,
        transactional_ddl=True,
        compare_type=True,
    )
    with context.begin_transaction():
        context.run_migrations()


run()
