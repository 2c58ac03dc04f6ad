"""The HTTP server of the API."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from ...core.run.errors import BadInput
from ..database import open_database
from ..home import use_home
from ..keys import list_keys
from ..settings import ServiceSettings
from ..signals import STOP_SIGNALS, handle_signals
from .connections import make_protocol
from .guard import HEAD_BYTES, is_loopback
from .limits import ApiLimits, read_limits

if TYPE_CHECKING:
    import uvicorn

IDLE_SECONDS = 30
"""Time for which a connection without a request is kept [s]; a client that follows a job sends requests more often."""

MAX_CONCURRENT_REQUESTS = 512
"""Largest number of requests at a time; further ones are answered 503 at once."""


class AddressPublic(BadInput):
    """A service that other machines reach needs keys; create one by `garmentq keys create NAME`, then serve again."""

    code = "serve.keys_missing"


class HostBad(BadInput):
    """A host is named as in a browser's address, such as garmentq.example, without scheme, port or path."""

    code = "serve.host_bad"


def serve(
    settings: ServiceSettings, host: str, port: int, limits: ApiLimits | None = None, hosts: Sequence[str] = (),
    needs_key: bool = True,
) -> None:  # fmt: skip
    """Serve the API until SIGINT, SIGTERM or SIGHUP.

    Args:
        settings: Settings of the home.
        host: Address to listen on.
        port: Port to listen on.
        limits: Limits of requests; None: as the environment says.
        hosts: Host names under which a proxy on this machine calls it.
        needs_key: Refuse to start if other machines can reach it and no key exists; if False, every request is refused
            until a key exists.

    Raises:
        AddressPublic: if other machines can reach it, by the address or by a proxy, and no key exists.
        HostBad: if a host name is invalid.
        ServiceSettingBad: if the environment has an invalid limit, origin or proxy.
    """
    import uvicorn

    in_use = use_home(settings)
    if needs_key:
        check_keys(settings, host, hosts)
    from .app import make_app

    limits = limits or read_limits()
    app = make_app(settings, limits, is_loopback(host), read_hosts(hosts))
    config = uvicorn.Config(app, host=host, port=port, log_level="warning", log_config=None, **make_options(limits))
    try:
        make_server(config).run()
    finally:
        os.close(in_use)


def check_keys(settings: ServiceSettings, host: str, hosts: Sequence[str] = ()) -> None:
    """Check that a service that other machines reach has a key; arguments as for `serve`.

    Raises:
        AddressPublic: if it has none.
        HostBad: if a host name is invalid.
    """
    if not read_hosts(hosts) and is_loopback(host):
        return
    database = open_database(settings)
    try:
        if not any(row.revoked is None for row in list_keys(database)):
            raise AddressPublic()
    finally:
        database.dispose()


def make_server(config: uvicorn.Config) -> uvicorn.Server:
    """Return a server that stops gracefully on a stop signal, and then returns.

    uvicorn's own server raises the signal again after it has stopped, which ends the process before other clean-up, and
    does not handle SIGHUP.
    """
    import uvicorn

    class Server(uvicorn.Server):
        """Serve until a stop signal."""

        @contextmanager
        def capture_signals(self) -> Iterator[None]:
            """Handle the stop signals, except ignored ones (nohup)."""
            numbers = [number for number in STOP_SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
            with handle_signals(numbers, self.handle_exit):
                yield

    return Server(config)


def make_options(limits: ApiLimits) -> dict[str, Any]:
    """Return uvicorn's options; proxy headers are off because the application handles them itself."""
    return {
        "access_log": False,
        "server_header": False,
        "proxy_headers": False,
        "timeout_keep_alive": IDLE_SECONDS,
        "limit_concurrency": MAX_CONCURRENT_REQUESTS,
        "http": make_protocol(limits),
        "h11_max_incomplete_event_size": HEAD_BYTES,
        "timeout_graceful_shutdown": 10,
    }


def read_hosts(names: Sequence[str]) -> tuple[str, ...]:
    """Return host names in lower case, as `urlsplit` returns them.

    Raises:
        HostBad: if one is invalid.
    """
    for name in names:
        if not re.fullmatch(r"[A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?", name):
            raise HostBad(f"'{name[:80]}' is not a host. {HostBad().message}")
    return tuple(name.lower() for name in names)
