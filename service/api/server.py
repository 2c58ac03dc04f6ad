"""Listen on an address."""

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
"""How long a connection without a request is kept [s]; a client that follows a job asks more often."""

MAX_CONCURRENT_REQUESTS = 512
"""Largest number of requests at a time; more are answered 503 at once."""


class AddressPublic(BadInput):
    """A service that others reach needs keys; make one by `garmentq keys create NAME`, then serve again."""

    code = "serve.keys_missing"


class HostBad(BadInput):
    """A host is named as browsers name it, such as garmentq.example, without scheme, port or path."""

    code = "serve.host_bad"


def serve(
    settings: ServiceSettings, host: str, port: int, limits: ApiLimits | None = None, hosts: Sequence[str] = (),
    needs_key: bool = True,
) -> None:  # fmt: skip
    """Serve the API until SIGINT, SIGTERM or SIGHUP tells it to stop.

    Args:
        settings: Which home.
        host: Address to listen on.
        port: Port to listen on.
        limits: What a request may cost; None: as the environment says.
        hosts: Names by which a proxy on this machine calls it.
        needs_key: Refuse to start where others may come while nobody has a key; otherwise everybody is refused until
            somebody has.

    Raises:
        AddressPublic: where others may come, by the address or by a proxy, and nobody has a key.
        HostBad: where a name is none.
        ServiceSettingBad: where the environment names a limit, an origin or a proxy that is none.
    """
    import uvicorn

    in_use = use_home(settings)
    database = open_database(settings)
    is_near, hosts = is_loopback(host), read_hosts(hosts)
    is_reached = bool(hosts) or not is_near
    if needs_key and is_reached and not any(row.revoked is None for row in list_keys(database)):
        raise AddressPublic()
    database.dispose()
    from .app import make_app

    limits = limits or read_limits()
    app = make_app(settings, limits, is_near, hosts)
    config = uvicorn.Config(app, host=host, port=port, log_level="warning", **make_options(limits))
    try:
        make_server(config).run()
    finally:
        os.close(in_use)


def make_server(config: uvicorn.Config) -> uvicorn.Server:
    """Return a server that ends in order when it is told to stop, and returns.

    uvicorn's own raises the signal once more when it has ended, which ends the process before anything else is undone,
    and does not know SIGHUP.
    """
    import uvicorn

    class Server(uvicorn.Server):
        """Serve until told to stop."""

        @contextmanager
        def capture_signals(self) -> Iterator[None]:
            """Listen to what tells a server to stop, but to nothing that is ignored (nohup)."""
            told = [number for number in STOP_SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
            with handle_signals(told, self.handle_exit):
                yield

    return Server(config)


def make_options(limits: ApiLimits) -> dict[str, Any]:
    """Return how uvicorn serves the application, whose own matter it is whom a proxy's headers are believed of."""
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
    """Return names of hosts in small letters, as `urlsplit` gives them.

    Raises:
        HostBad: where one is none.
    """
    for name in names:
        if not re.fullmatch(r"[A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?", name):
            raise HostBad(f"'{name[:80]}' is no host. {HostBad().message}")
    return tuple(name.lower() for name in names)
