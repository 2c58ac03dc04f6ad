"""A job as a program holds it: wait for its end, then ask for the pattern, the meshes or the files."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.run.errors import GarmentqError, NotFound
from .backend import Backend
from .kinds.redrape_request import REDRAPE
from .records import Job, JobReport
from .states import ENDED, State

if TYPE_CHECKING:
    from ..core.body.body import Body
    from ..core.cloth.fabric import Fabric
    from ..core.deliver.export.sewn_mesh import SewnMesh
    from ..core.deliver.export.stored_result import StoredResult
    from ..core.garment.pattern import Pattern

__all__ = ["JobHandle"]


WAIT_SECONDS = 30.0
"""Time for which one request waits for a job's end [s]; a proxy closes a silent connection after 60."""


class JobUnsuccessful(GarmentqError):
    """The job has ended without a result; its message says why, `retry()` queues it again."""

    code = "job.unsuccessful"


class JobUnended(GarmentqError):
    """The job has not ended in this time; wait again, it goes on."""

    code = "job.unended"


class GarmentUnnamed(NotFound):
    """The job has several garments, or none of this name; `garments` has them by name."""

    code = "job.garment_unnamed"


class JobHandle:
    """Describe a job of a service or a home.

    Attributes:
        id: The job's id.
        report: What was known of it when it was last asked for.
    """

    def __init__(self, backend: Backend, job: str) -> None:
        """Find the job.

        Args:
            backend: Where the job is.
            job: Its id, or a beginning of it.

        Raises:
            JobUnknown: if there is none.
        """
        self._backend = backend
        self.report: JobReport = backend.find_job(job)
        self.id = self.report.id

    def __repr__(self) -> str:
        """Return a short description: `<JobHandle 3685ecfd4f81 'anna' running 43 %>`."""
        share = f" {100.0 * self.report.overall:.0f} %" if self.state == State.RUNNING else ""
        return f"<JobHandle {self.id} {self.name!r} {self.state}{share}>"

    @property
    def name(self) -> str:
        """Return its name."""
        return self.report.name

    @property
    def state(self) -> State:
        """Return its state when it was last asked for."""
        return self.report.state

    @property
    def metrics(self) -> Mapping[str, float | None]:
        """Return its metrics by dotted name."""
        return self.report.metrics

    @property
    def verdict(self) -> str | None:
        """Return the worst verdict of its gates, `pass`, `doubtful` or `fail`."""
        return self.report.verdict

    @property
    def garments(self) -> dict[str, JobHandle]:
        """Return the jobs of a person's garments by name (`upper`, `lower`, ...); of a garment itself."""
        below = [child for child in self.report.children if child.kind != REDRAPE]
        return {child.name: JobHandle(self._backend, child.job) for child in below} or {self.name: self}

    @cached_property
    def result(self) -> StoredResult:
        """Return the garment's result; only the files that are read are copied.

        Raises:
            JobUnsuccessful, JobUnended: if it has none.
            GarmentUnnamed: for a person with several garments.
        """
        from .opening import read_result

        self._check_succeeded(self.report)
        garments = self.garments
        if len(garments) > 1:
            raise GarmentUnnamed(f"job {self.id} has the garments {', '.join(garments)}; choose one of `garments`.")
        return read_result(self._backend, next(iter(garments.values())).id)

    @property
    def pattern(self) -> Pattern:
        """Return the sewing pattern."""
        return self.result.pattern

    @property
    def fabric(self) -> Fabric:
        """Return the cloth, recovered or chosen."""
        return self.result.fabric

    @property
    def body(self) -> Body:
        """Return the wearer in the scan's pose."""
        return self.result.body

    def mesh(self, name: str) -> SewnMesh:
        """Return a mesh of the result, `detail` or `simulation`."""
        return self.result.mesh(name)

    def refresh(self) -> JobHandle:
        """Return the job, asked for again."""
        self.report = self._backend.find_job(self.id)
        self.__dict__.pop("result", None)
        return self

    def wait(self, timeout: float | None = None) -> JobHandle:
        """Wait until the job and those of its garments have ended, and return it. A re-drape may still run.

        Args:
            timeout: Longest time [s]; None: for ever.

        Raises:
            JobUnsuccessful: if one failed, or was cancelled.
            JobUnended: if they run after that time; they go on.
        """
        end = None if timeout is None else time.monotonic() + timeout
        while True:
            known = [one for one in self._backend.find_jobs_by_id([self.id], below=True) if one.kind != REDRAPE]
            unended = [one for one in known if one.state not in ENDED]
            if not unended:
                break
            left = WAIT_SECONDS if end is None else end - time.monotonic()
            if left < 0.0:
                raise JobUnended(f"job {self.id} has not ended after {timeout:.0f} s; wait again, it goes on.")
            self._backend.wait_job(unended[0].id, min(left, WAIT_SECONDS))
        self.refresh()
        for one in known:
            self._check_succeeded(one)
        return self

    def cancel(self) -> JobHandle:
        """Cancel the job and those below it."""
        self._backend.cancel(self.id)
        return self.refresh()

    def retry(self) -> JobHandle:
        """Queue an ended job again."""
        self._backend.retry(self.id)
        return self.refresh()

    def export_files(self, folder: str | Path, names: Sequence[str] = ()) -> list[Path]:
        """Copy the job's result files into a folder, all or those named."""
        Path(folder).mkdir(parents=True, exist_ok=True)
        return self._backend.export_files(self.id, Path(folder), names)

    def read_file(self, name: str) -> bytes:
        """Return the content of a file of the job's result."""
        with tempfile.TemporaryDirectory(prefix="garmentq-result-") as folder:
            return self.export_files(folder, [name])[0].read_bytes()

    def _check_succeeded(self, job: Job) -> None:
        if job.state not in ENDED:
            raise JobUnended(f"job {job.id} is {job.state}; `wait()` for its end.")
        if job.state != State.SUCCEEDED:
            why = f"{job.error.code}: {job.error.message}" if job.error else f"it is {job.state}."
            raise JobUnsuccessful(f"job {job.id} '{job.name}' has no result: {why}")
