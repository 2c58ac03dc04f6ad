"""The table of share links."""

from __future__ import annotations

from sqlalchemy import ForeignKey
from sqlalchemy.orm import Mapped, mapped_column

from .columns import Words
from .model_base import Base


class ShareRow(Base):
    """Store a link that shows one result to whoever has it, by its token's hash; it is deleted with its job.

    `key` made it (empty: the local user); `opened` counts how often its page was shown.
    """

    __tablename__ = "shares"
    id: Mapped[str] = mapped_column(Words(16), primary_key=True)
    hash: Mapped[str] = mapped_column(Words(64), unique=True)
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), index=True)
    key: Mapped[str] = mapped_column(Words(16))
    created: Mapped[float]
    expires: Mapped[float] = mapped_column(index=True)
    opened: Mapped[int] = mapped_column(default=0)
