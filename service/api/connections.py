"""What one connection, and one address, may hold of the service before it has asked for anything."""

from __future__ import annotations

import asyncio
from collections import Counter
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from .limits import ApiLimits


def make_protocol(limits: ApiLimits) -> type[H11Protocol]:
    """Return the protocol of a server: it closes what sends no whole head in time or is one too many.

    uvicorn itself waits for a head without end, and refuses everybody once there are as many connections as it allows.
    """
    held: Counter[str] = Counter()

    class Bounded(H11Protocol):
        """Speak HTTP/1.1 with a deadline for each head."""

        _address: str | None = None
        _deadline: asyncio.TimerHandle | None = None

        def connection_made(self, transport: Any) -> None:
            """Count the connection, or close it at once."""
            super().connection_made(transport)
            address = self.client[0] if self.client else ""
            if held[address] >= limits.connections_per_address:
                transport.abort()
                return
            self._address = address
            held[address] += 1
            self._wait_for_head()

        def connection_lost(self, exc: Exception | None) -> None:
            """Count it no more."""
            self._stop_waiting()
            if self._address is not None:
                held[self._address] -= 1
                if not held[self._address]:
                    del held[self._address]
                self._address = None
            super().connection_lost(exc)

        def data_received(self, data: bytes) -> None:
            """Take what came; the deadline is for the whole head, however slowly its bytes drip in."""
            super().data_received(data)
            if self.conn.their_state is h11.IDLE:
                self._wait_for_head()
            else:
                self._stop_waiting()

        def _wait_for_head(self) -> None:
            if self._deadline is None:
                self._deadline = self.loop.call_later(limits.head_seconds, self.transport.abort)

        def _stop_waiting(self) -> None:
            if self._deadline is not None:
                self._deadline.cancel()
                self._deadline = None

    return Bounded
