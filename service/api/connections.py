"""Limits of one connection and of one address, before a request is complete."""

from __future__ import annotations

import asyncio
import socket
from collections import Counter
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from .limits import ApiLimits

UNSENT_BYTES = 1 << 17
"""Size of what the system buffers of a response beyond the client's room for it [bytes]. By default it buffers
megabytes, and a client that reads slowly would seem to read nothing while they are sent."""

STALL_CHECK_COUNT = 4
"""Number of checks within `stalled_seconds` whether the client has read more of a response."""


def make_protocol(limits: ApiLimits) -> type[H11Protocol]:
    """Return the protocol of a server that closes connections which stall or exceed the number per address.

    A connection stalls if it sends no complete head, or does not read its response. uvicorn itself waits for both
    without limit, and refuses every client once it has reached its number of connections.
    """
    open_counts: Counter[str] = Counter()

    class Bounded(H11Protocol):
        """Speak HTTP/1.1 with a deadline for each head and for each part of a response."""

        _address: str | None = None
        _deadline: asyncio.TimerHandle | None = None
        _stall_timer: asyncio.TimerHandle | None = None
        _unread = 0
        _moved = 0.0

        def connection_made(self, transport: Any) -> None:
            """Count the connection, or close it at once."""
            super().connection_made(transport)
            address = self.client[0] if self.client else ""
            if open_counts[address] >= limits.connections_per_address:
                transport.abort()
                return
            self._address = address
            open_counts[address] += 1
            self._wait_for_head()
            if connected := transport.get_extra_info("socket"):
                connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_BYTES)
            self._check_stall()

        def connection_lost(self, exc: Exception | None) -> None:
            """Stop counting the connection."""
            self._stop_waiting()
            if self._stall_timer is not None:
                self._stall_timer.cancel()
            if self._address is not None:
                open_counts[self._address] -= 1
                if not open_counts[self._address]:
                    del open_counts[self._address]
                self._address = None
            super().connection_lost(exc)

        def data_received(self, data: bytes) -> None:
            """Process received data; the deadline applies to the complete head, however slowly its bytes arrive."""
            super().data_received(data)
            if self.conn.their_state is h11.IDLE:
                self._wait_for_head()
            else:
                self._stop_waiting()

        def resume_writing(self) -> None:
            """Continue a response of which the client has read a part."""
            self._moved = self.loop.time()
            super().resume_writing()

        def _check_stall(self) -> None:
            """Close a connection whose response was not read for too long; otherwise schedule the next check."""
            unread, now = self.transport.get_write_buffer_size(), self.loop.time()
            if unread != self._unread or not unread:
                self._unread, self._moved = unread, now
            elif now - self._moved >= limits.stalled_seconds:
                self.transport.abort()
                return
            self._stall_timer = self.loop.call_later(limits.stalled_seconds / STALL_CHECK_COUNT, self._check_stall)

        def _wait_for_head(self) -> None:
            if self._deadline is None:
                self._deadline = self.loop.call_later(limits.head_seconds, self.transport.abort)

        def _stop_waiting(self) -> None:
            if self._deadline is not None:
                self._deadline.cancel()
                self._deadline = None

    return Bounded
