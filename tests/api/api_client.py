"""A real server in a thread, and a client of it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import httpx
import pytest
import uvicorn
from garmentq.service.api.app import make_app
from garmentq.service.api.limits import ApiLimits
from garmentq.service.api.server import make_options
from garmentq.service.database import open_database
from garmentq.service.local_token import make_local_token
from garmentq.workers.courier import deliver
from garmentq_home import wait_for

LIMITS = ApiLimits(upload_bytes=1 << 20, chunk_seconds=1.0, streams=2)


@contextmanager
def serving(settings, limits: ApiLimits = LIMITS, is_open: bool = True, hosts=()) -> Iterator[str]:
    """Serve a home as `garmentq serve` does, on a free port for the block, and give its address."""
    app = make_app(settings, limits, is_open, hosts)
    chosen = make_options(limits) | {"timeout_graceful_shutdown": 1}
    options = uvicorn.Config(app, host="127.0.0.1", port=0, log_level="critical", **chosen)
    server = uvicorn.Server(options)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    try:
        wait_for(lambda: server.started)
        port = server.servers[0].sockets[0].getsockname()[1]
        yield f"http://127.0.0.1:{port}"
    finally:
        server.should_exit = True
        thread.join(10)
        app.state.rooms.database.dispose()


def local_user(settings) -> dict[str, str]:
    """Return the header of the local user of a service without keys."""
    return {"authorization": f"Bearer {make_local_token(settings.home)}"}


@contextmanager
def carrying(settings) -> Iterator[None]:
    """Let a courier send what is owed to webhooks, for the block."""
    database, ended = open_database(settings), threading.Event()

    def carry() -> None:
        while not ended.wait(0.05):
            asyncio.run(deliver(database, settings.webhook_networks))

    thread = threading.Thread(target=carry, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        database.dispose()


@pytest.fixture
def address(settings) -> Iterator[str]:
    """Serve the home."""
    with serving(settings) as url:
        yield url


@pytest.fixture
def client(address, settings) -> Iterator[httpx.Client]:
    """Return a client of the served home, as the local user."""
    with httpx.Client(base_url=address, timeout=30.0, headers=local_user(settings)) as opened:
        yield opened
