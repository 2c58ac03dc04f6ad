"""What every kind of job is made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from ...core.run.errors import GarmentqError
    from ...core.run.hooks import Hooks
    from ...core.run.sandbox import IsStopped
    from ..jobs import Claim
    from ..models import JobRow
    from ..settings import ServiceSettings
    from ..store import Store

PARENT = "parent"
"""Stands among a child's inputs for the job that it is made by."""


@dataclass(frozen=True)
class ChildRequest:
    """Ask for one child, made in the transaction that stores its parent's result.

    Attributes:
        name: What it is called; unlike any sibling's. With the parent's id it makes the child exactly once.
        kind: Name of its kind.
        request: Its request, as `pack_request` writes it.
        waits: Names of siblings before it that must have succeeded before it begins.
        inputs: The results that it reads: `PARENT`, the name of a sibling that it waits for, or a job's id, by the name
            of the folder in which the child finds the files.
        queue: One of `QUEUES`; None: its parent's.
    """

    name: str
    kind: str
    request: dict[str, Any]
    waits: tuple[str, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    queue: str | None = None


@dataclass(frozen=True)
class Outcome:
    """What storing a result leaves for the job's row.

    Attributes:
        summary: JSON values for the row's `result`: `gates`, `warnings`, `stage_seconds`, `cpu_seconds` and `peak_mb`
            are shown by their names.
        children: What is to be done next.
        failure: Why the job ends as failed all the same, where there is something to look at: its files and rows are
            kept, and children it has none. None: it succeeded.
    """

    summary: dict[str, Any]
    children: tuple[ChildRequest, ...] = ()
    failure: GarmentqError | None = None


@dataclass(frozen=True)
class KindChange:
    """State that a job's files are what another kind works on.

    Attributes:
        kind: Name of that kind.
        request: Its request, as `pack_request` writes it.
    """

    kind: str
    request: dict[str, Any]


@dataclass(frozen=True)
class RunContext:
    """What a run has beside its request.

    Attributes:
        settings: Where everything is.
        files: Holds each file of the request, as FIELD/NAME.
        inputs: Folder of the result files of each job that is read, by the input's name.
        out: Takes the files of the result; names below it are kept.
    """

    settings: ServiceSettings
    files: Path
    inputs: Mapping[str, Path]
    out: Path


class Kind(ABC):
    """One kind of job. It has no state; a worker and the service make one whenever they need it.

    Attributes:
        name: Stored with each job.
        request: Frozen dataclass of what is asked for; `read_request` and `pack_request` turn it from and to JSON.
        stages: Names of the stages in order, by which progress is reported; the first is always `check`.
        reads: Of a kind whose jobs are derived from stored results: the kinds of job that each input may be, by the
            input's name.
        persons: Name of the kind that takes the place of this one where a person's job is named as the result; empty:
            none does.
        reads_too: The same of an input that a job may do without; `DerivedOrder.over` names its job.
    """

    name: ClassVar[str]
    request: ClassVar[type[Any]]
    stages: ClassVar[tuple[str, ...]]
    reads: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})
    reads_too: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})
    persons: ClassVar[str] = ""

    def checker(self, settings: ServiceSettings) -> str:
        """Return what reads the user's bytes and refuses what cannot be used: the first stage, in a limited process.

        Returns:
            Dotted path of a function, `package.module:name`, as `checking.check_recovery` is; empty where a job has no
            files of a user's own. Its module should be light: a fresh process imports it for each job. It is not called
            for a request that names no file.
        """
        return ""

    def refuse(self, store: Store, request: Any, is_stopped: IsStopped) -> None:
        """Refuse a derived job when it is submitted, where its own small files cannot be used; in a limited process.

        What is let through is checked again by `checker`.

        Raises:
            BadInput: where they cannot.
        """
        return

    @property
    def is_refused_early(self) -> bool:
        """Return whether `refuse` does anything, so that a service counts it."""
        return type(self).refuse is not Kind.refuse

    def adopt(self, session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
        """Return a derived job's request with what it takes of the job whose result it reads, when it is submitted.

        Args:
            session: Where that job is.
            request: As `pack_request` writes it.
            row: That job.
        """
        return request

    def find_inputs(self, session: Session, request: dict[str, Any], row: JobRow) -> dict[str, str]:
        """Return further jobs whose results a derived job reads, by the input's name, when it is submitted.

        Args:
            session: Where the jobs are.
            request: As `adopt` returned it.
            row: The job that it was asked of.
        """
        return {}

    def turn(self, request: Any, work: RunContext, hooks: Hooks) -> KindChange | None:
        """Return what the job is instead, where its files turn out to be what another kind works on; after the check.

        The job keeps its id, and what makes it the same as another.
        """
        return None

    def choose_input(self, request: Any, name: str) -> tuple[str, ...]:
        """Return the names of the files that the job reads of an input's result; empty: all of them."""
        return ()

    @abstractmethod
    def run(self, request: Any, work: RunContext, hooks: Hooks) -> Any:
        """Do the work, write its files into `work.out`, and return the result."""

    @abstractmethod
    def store(self, session: Session, claim: Claim, result: Any) -> Outcome:
        """Add the result's rows, in the transaction that ends the job; the files are kept already."""

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return what this kind shows of a job, as JSON values; the same names for every state."""
        return {}
