"""The client for programs that wait for many things at once: each request runs in a thread of its own."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, Self, TypeVar

from ..core.run.errors import GarmentqError
from .client import Client
from .job_handle import JobHandle

if TYPE_CHECKING:
    from ..core.deliver.export.stored_result import StoredResult

__all__ = ["AsyncClient", "AsyncJob"]

P = ParamSpec("P")
T = TypeVar("T")


class AsyncJob:
    """Describe a job as `JobHandle` does; what asks the service is awaited.

    Attributes:
        handle: The job, as it was last asked for.
    """

    def __init__(self, handle: JobHandle) -> None:
        """Take a job's handle."""
        self.handle = handle

    def __repr__(self) -> str:
        """Return a short description."""
        return repr(self.handle).replace("JobHandle", "AsyncJob")

    @property
    def id(self) -> str:
        """Return the job's id."""
        return self.handle.id

    async def wait(self, timeout: float | None = None) -> AsyncJob:
        """Wait until the job and those of its garments have ended, as `JobHandle.wait` does, and return it."""
        await asyncio.to_thread(self.handle.wait, timeout)
        return self

    async def result(self) -> StoredResult:
        """Return the garment's result: its pattern, meshes, fabric and wearer."""
        return await asyncio.to_thread(lambda: self.handle.result)

    async def garments(self) -> dict[str, AsyncJob]:
        """Return the jobs of a person's garments by name; of a garment itself."""
        found = await asyncio.to_thread(lambda: self.handle.garments)
        return {name: AsyncJob(one) for name, one in found.items()}

    async def cancel(self) -> AsyncJob:
        """Cancel the job and those below it."""
        await asyncio.to_thread(self.handle.cancel)
        return self


class AsyncClient:
    """Call a service without blocking the event loop.

    async with AsyncClient("http://127.0.0.1:8080") as service:
        jobs = await asyncio.gather(*(service.recover(scan) for scan in scans))
        done = await asyncio.gather(*(job.wait() for job in jobs))

    Attributes:
        client: The client; `await service.call(service.client.read_queue)` calls any other route.
    """

    def __init__(self, url: str = "", key: str | None = None) -> None:
        """Prepare a client, as `Client` is prepared."""
        self.client = Client(url, key)

    def __repr__(self) -> str:
        """Return a short description, without the key."""
        return repr(self.client).replace("Client", "AsyncClient")

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection."""
        self.client.close()

    async def call(self, method: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a method of the client in a thread, and return what it returns."""
        return await asyncio.to_thread(method, *args, **kwargs)

    async def recover(
        self, scan: str | Path, body: str | Path | None = None, *, tags: Sequence[str] = (), **options: Any
    ) -> AsyncJob:
        """Upload a scan, queue its recovery, and return the job; options are those of `Client.recover`."""
        return AsyncJob(await asyncio.to_thread(lambda: self.client.recover(scan, body, tags=tags, **options)))

    async def recover_many(
        self, scans: Sequence[str | Path], body: str | Path | None = None, *, tags: Sequence[str] = (), **options: Any
    ) -> list[AsyncJob | GarmentqError]:
        """Upload scans and queue their recoveries, as `Client.recover_many` does; return a job or refusal for each."""
        found = await asyncio.to_thread(lambda: self.client.recover_many(scans, body, tags=tags, **options))
        return [one if isinstance(one, GarmentqError) else AsyncJob(one) for one in found]

    async def job(self, job: str) -> AsyncJob:
        """Return a job by its id or a beginning of it."""
        return AsyncJob(await asyncio.to_thread(self.client.job, job))
