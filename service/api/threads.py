"""Threads for one kind of short work each, which never wait for those that slow routes hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

from anyio import CapacityLimiter, to_thread

Result = TypeVar("Result")


class ThreadPool:
    """Run blocking functions in a number of threads, apart from those that the routes share."""

    def __init__(self, most: int) -> None:
        """Begin with none.

        Args:
            most: Threads at a time.
        """
        self._limiter = CapacityLimiter(most)

    async def run(self, function: Callable[..., Result], *arguments: object) -> Result:
        """Run a function in one of the threads, and return what it returns."""
        return await to_thread.run_sync(function, *arguments, limiter=self._limiter)


@dataclass(frozen=True)
class ThreadPools:
    """Gather the threads that a server has beside those of the routes.

    Attributes:
        admission: Find who asks: one row of the database for each request.
        watching: Tell whether database and store can be used.
        transfers: Hash and move an upload into the store; one of 512 MB takes seconds, and a disk's whole speed.
    """

    admission: ThreadPool = field(default_factory=lambda: ThreadPool(16))
    watching: ThreadPool = field(default_factory=lambda: ThreadPool(2))
    transfers: ThreadPool = field(default_factory=lambda: ThreadPool(8))
