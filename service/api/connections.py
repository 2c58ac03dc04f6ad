"""What one connection, and one address, may hold of the service before it has asked for anything."""

from __future__ import annotations

import asyncio
import socket
from collections import Counter
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from .limits import ApiLimits

UNSENT_BYTES = 1 << 17
"""Bytes of an answer that the system takes ahead of what the client has room for. It would take megabytes, and a client
that reads slowly would seem to read nothing for as long as those last."""

STALL_CHECK_COUNT = 4
"""Number of checks within `stalled_seconds` whether an unread answer has become shorter."""


def make_protocol(limits: ApiLimits) -> type[H11Protocol]:
    """Return the protocol of a server: it closes what sends no whole head, leaves its answer unread or is one too many.

    uvicorn itself waits for both without end, and refuses everybody once there are as many connections as it allows.
    """
    held: Counter[str] = Counter()

    class Bounded(H11Protocol):
        """Speak HTTP/1.1 with a deadline for each head, and one for each step of an answer."""

        _address: str | None = None
        _deadline: asyncio.TimerHandle | None = None
        _look: asyncio.TimerHandle | None = None
        _unread = 0
        _moved = 0.0

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
            if connected := transport.get_extra_info("socket"):
                connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_BYTES)
            self._look_again()

        def connection_lost(self, exc: Exception | None) -> None:
            """Count it no more."""
            self._stop_waiting()
            if self._look is not None:
                self._look.cancel()
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

        def resume_writing(self) -> None:
            """Go on with an answer of which the client has read."""
            self._moved = self.loop.time()
            super().resume_writing()

        def _look_again(self) -> None:
            """Close a connection whose answer has lain unread for too long, and else look again later."""
            unread, now = self.transport.get_write_buffer_size(), self.loop.time()
            if unread != self._unread or not unread:
                self._unread, self._moved = unread, now
            elif now - self._moved >= limits.stalled_seconds:
                self.transport.abort()
                return
            self._look = self.loop.call_later(limits.stalled_seconds / STALL_CHECK_COUNT, self._look_again)

        def _wait_for_head(self) -> None:
            if self._deadline is None:
                self._deadline = self.loop.call_later(limits.head_seconds, self.transport.abort)

        def _stop_waiting(self) -> None:
            if self._deadline is not None:
                self._deadline.cancel()
                self._deadline = None

    return Bounded
