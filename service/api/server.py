"""Listen on an address."""

from __future__ import annotations

import os

from ...core.errors import BadInput
from ..database import open_database
from ..home import use_home
from ..keys import list_keys
from ..settings import ServiceSettings
from .connections import make_protocol
from .guard import HEAD_BYTES, is_loopback
from .limits import ApiLimits, read_limits

IDLE_SECONDS = 30
"""How long a connection without a request is kept [s]; a client that follows a job asks more often."""

CONNECTIONS = 512
"""Requests at a time; more are answered 503 at once."""


class AddressPublic(BadInput):
    """An address beyond this machine needs keys; make one by `garmentq keys create NAME`, then serve again."""

    code = "serve.keys_missing"


def serve(settings: ServiceSettings, host: str, port: int, limits: ApiLimits | None = None) -> None:
    """Serve the API until told to stop.

    Raises:
        AddressPublic: where the address is public and nobody has a key.
        ServiceSettingBad: where the environment names a limit that is none.
    """
    import uvicorn

    in_use = use_home(settings)
    database = open_database(settings)
    is_near = is_loopback(host)
    if not is_near and not any(row.revoked is None for row in list_keys(database)):
        raise AddressPublic()
    database.dispose()
    from .app import make_app

    limits = limits or read_limits()
    uvicorn.run(
        make_app(settings, limits, is_open=is_near),
        host=host,
        port=port,
        log_level="warning",
        access_log=False,
        server_header=False,
        timeout_keep_alive=IDLE_SECONDS,
        limit_concurrency=CONNECTIONS,
        http=make_protocol(limits),
        h11_max_incomplete_event_size=HEAD_BYTES,
        timeout_graceful_shutdown=10,
    )
    os.close(in_use)
