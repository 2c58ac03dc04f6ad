"""The tables of subjects, with the jobs of each, and of batches."""

from __future__ import annotations

from sqlalchemy import ForeignKey, Index, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from .columns import Words
from .model_base import Base


class SubjectRow(Base):
    """Store a person who was scanned; it belongs to one API key (empty: the local user).

    `consented` and `consent_until` are when the person agreed and until when, `consent` says where that is written.
    `keep_days` after the newest job has ended, or at `keep_until`, all data of the person are deleted.
    """

    __tablename__ = "subjects"
    __table_args__ = (
        UniqueConstraint("key", "name"),
        Index("ix_subjects_key_created", "key", "created", "id"),
        Index("ix_subjects_created", "created", "id"),
    )
    id: Mapped[str] = mapped_column(Words(16), primary_key=True)
    key: Mapped[str] = mapped_column(Words(16))
    name: Mapped[str] = mapped_column(Words(255), index=True)
    note: Mapped[str] = mapped_column(Words(), default="")
    created: Mapped[float]
    consented: Mapped[float | None]
    consent: Mapped[str] = mapped_column(Words(255), default="")
    consent_until: Mapped[float | None]
    keep_days: Mapped[float | None]
    keep_until: Mapped[float | None]


class SubjectJobRow(Base):
    """Store the subject of a job; each job of a family has it, and only the subject's key owns the job."""

    __tablename__ = "subject_jobs"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    subject: Mapped[str] = mapped_column(ForeignKey("subjects.id", ondelete="CASCADE"), index=True)


class BatchRow(Base):
    """Store when a key (empty: the local user) last ordered a job with a tag: the jobs of a tag are a batch."""

    __tablename__ = "batches"
    __table_args__ = (Index("ix_batches_key_latest", "key", "latest", "tag"),)
    key: Mapped[str] = mapped_column(Words(16), primary_key=True)
    tag: Mapped[str] = mapped_column(Words(64), primary_key=True, index=True)
    latest: Mapped[float]
