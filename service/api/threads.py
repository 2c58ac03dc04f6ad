"""Thread pools for short work that must not wait for slow routes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

from anyio import CapacityLimiter, to_thread

Result = TypeVar("Result")


class ThreadPool:
    """Run blocking functions in a limited number of threads, separate from those of the routes."""

    def __init__(self, most: int) -> None:
        """Create the pool.

        Args:
            most: Largest number of threads.
        """
        self._limiter = CapacityLimiter(most)

    async def run(self, function: Callable[..., Result], *arguments: object) -> Result:
        """Run a function in one of the threads, and return its result."""
        return await to_thread.run_sync(function, *arguments, limiter=self._limiter)


@dataclass(frozen=True)
class ThreadPools:
    """Describe the thread pools that a server has beside that of the routes.

    Attributes:
        admission: Authenticates callers: one row of the database for each request.
        watching: Checks that database and store can be used.
        transfers: Hashes uploads and moves them into the store; one of 512 MB takes seconds at a disk's full speed.
    """

    admission: ThreadPool = field(default_factory=lambda: ThreadPool(16))
    watching: ThreadPool = field(default_factory=lambda: ThreadPool(2))
    transfers: ThreadPool = field(default_factory=lambda: ThreadPool(8))
