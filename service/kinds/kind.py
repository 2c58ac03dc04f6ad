"""The base class of every kind of job, and its records."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from ..lanes import Lane

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
"""Value of a child's input that stands for the job that creates the child."""


@dataclass(frozen=True)
class ChildRequest:
    """Describe one child, created in the transaction that stores its parent's result.

    Attributes:
        name: Its name, unique among its siblings. With the parent's id it ensures that the child is created once.
        kind: Name of its kind.
        request: Its request, as `pack_request` writes it.
        waits: Names of earlier siblings that must have succeeded before it begins.
        inputs: The results that it reads, by the name of the folder in which the child finds the files: `PARENT`, the
            name of a sibling that it waits for, or a job's id.
        queue: One of `QUEUES`; None: its parent's.
        priority: Its largest priority; None: its parent's.
        lane: Its lane; None: its parent's.
    """

    name: str
    kind: str
    request: dict[str, Any]
    waits: tuple[str, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    queue: str | None = None
    priority: int | None = None
    lane: Lane | None = None


@dataclass(frozen=True)
class Outcome:
    """Describe what the job's row keeps of a stored result.

    Attributes:
        summary: JSON values for the row's `result`: `gates`, `warnings`, `stage_seconds`, `cpu_seconds` and `peak_mb`
            are shown by their names.
        children: The jobs that follow.
        failure: Why the job ends as failed although it has a result: files and rows are kept, and no children are
            created. None: it succeeded.
    """

    summary: dict[str, Any]
    children: tuple[ChildRequest, ...] = ()
    failure: GarmentqError | None = None


@dataclass(frozen=True)
class KindChange:
    """Describe another kind to which a job's files belong.

    Attributes:
        kind: Name of that kind.
        request: Its request, as `pack_request` writes it.
    """

    kind: str
    request: dict[str, Any]


@dataclass(frozen=True)
class RunContext:
    """Describe what a run has beside its request.

    Attributes:
        settings: Settings of the home.
        files: Folder with each file of the request, as FIELD/NAME.
        inputs: Folder of the result files of each job that is read, by the input's name.
        out: Folder for the files of the result; names below it are kept.
    """

    settings: ServiceSettings
    files: Path
    inputs: Mapping[str, Path]
    out: Path


class Kind(ABC):
    """Define one kind of job. An instance has no state; workers and the service create one when they need it.

    Attributes:
        name: Stored with each job.
        request: Frozen dataclass of the request; `read_request` and `pack_request` convert it from and to JSON.
        stages: Names of the stages in order, by which progress is reported; the first is always `check`.
        reads: For a kind of derived jobs: the kinds of job that each input may be, by the input's name.
        persons: Name of the kind that replaces this one if a person's job is named as the result; empty: none.
        reads_too: The same as `reads` for an optional input; `DerivedOrder.over` names its job.
        changes: Name of the input whose rows `store` changes too, of the job that made this one; empty: none.
        lane: Lane of a derived job of this kind.
    """

    name: ClassVar[str]
    request: ClassVar[type[Any]]
    stages: ClassVar[tuple[str, ...]]
    reads: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})
    reads_too: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})
    persons: ClassVar[str] = ""
    changes: ClassVar[str] = ""
    lane: ClassVar[Lane] = Lane.BATCH

    def checker(self, settings: ServiceSettings) -> str:
        """Return the function that reads and checks the user's files: the first stage, in a limited process.

        Returns:
            Dotted path of a function like `checking.check_recovery`, `package.module:name`; empty if a job has no files
            of a user. Its module should be light: a new process imports it for each job. It is not called for a request
            that names no file.
        """
        return ""

    def refuse(self, store: Store, request: Any, is_stopped: IsStopped) -> None:
        """Refuse a derived job when it is submitted if its own small files cannot be used; in a limited process.

        Accepted files are checked again by `checker`.

        Raises:
            BadInput: if they cannot be used.
        """
        return

    @property
    def is_refused_early(self) -> bool:
        """Return whether this kind implements `refuse`, so that a service counts the call."""
        return type(self).refuse is not Kind.refuse

    def adopt(self, session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
        """Return a derived job's request, completed from the job whose result it reads, when it is submitted.

        Args:
            session: Session with that job.
            request: As `pack_request` writes it.
            row: That job.
        """
        return request

    def find_inputs(self, session: Session, request: dict[str, Any], row: JobRow) -> dict[str, str]:
        """Return further jobs whose results a derived job reads, by the input's name, when it is submitted.

        Args:
            session: Session with the jobs.
            request: As `adopt` returned it.
            row: The job whose result it reads.
        """
        return {}

    def turn(self, request: Any, work: RunContext, hooks: Hooks) -> KindChange | None:
        """Return the kind to which the job's files belong if it is another one; called after the check.

        The job keeps its id and its identity among equal orders.
        """
        return None

    def choose_input(self, request: Any, name: str) -> tuple[str, ...]:
        """Return the names of the files that the job reads of an input's result; empty: all of them."""
        return ()

    @abstractmethod
    def run(self, request: Any, work: RunContext, hooks: Hooks) -> Any:
        """Run the job, write its files into `work.out`, and return the result."""

    @abstractmethod
    def store(self, session: Session, claim: Claim, result: Any) -> Outcome:
        """Add the result's rows, in the transaction that ends the job; the files are stored already."""

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return the fields of this kind that are shown for a job, as JSON values; the same names in every state."""
        return {}
