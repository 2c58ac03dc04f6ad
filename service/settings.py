"""Where the service keeps its things, and the times it works with; all of it read from the environment."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit, urlunsplit

from ..core.errors import BadInput

PIPELINE = "garmentq.core.pipeline:recover"
"""What a job runs. Tests of the queue put a quick stand-in here."""

WRITER = "garmentq.core.export:write_recovery"
"""What turns a recovery into files."""

CHECKER = "garmentq.core.scan:load_pieces"
"""What looks at a scan and its body before they are queued."""


class ServiceSettingBad(BadInput):
    """A GARMENTQ_ environment variable has a value that cannot be used; see docs/service.md."""

    code = "service.setting_bad"


@dataclass(frozen=True)
class ServiceSettings:
    """Choose where jobs live and how long things may take; each field is read from `GARMENTQ_` + NAME.

    Attributes:
        home: Folder of the embedded database, broker, store and logs; the XDG data folder, so that no root is needed.
        database_url: SQLAlchemy address; empty: SQLite in `home`, which needs no server.
        broker_url: Redis or Valkey address; empty: an embedded Valkey, started on demand.
        store: Folder of the artifacts; empty: `home/store`.
        lease_seconds: How long a claim holds without a heartbeat [s]. 30 s is three missed heartbeats of a busy
            machine; a crash costs at most this and the work since the last checkpoint.
        max_attempts: Claims of one job before it ends as `dead`; a third crash in a row is no bad luck.
        max_seconds: Longest time that one attempt may take [s]; an ordinary job takes one to two minutes.
        poll_seconds: Period of the dispatcher and of the cancel check [s]; half a second is not noticed by a person.
        republish_seconds: A queued job that saw no event for so long is published again [s] if the broker holds no
            message: it must have lost it. A needless message does no harm.
        grace_seconds: How long a job that was told to stop may take to do so [s]; then its process ends under it. A
            stage asks several times a second, and containers are killed after 10 to 30 s.
        idle_seconds: The embedded worker and broker stop after so long without a job [s]; 0: never.
        log_json: 1: the worker writes its log as one JSON object a line.
        threads: Threads of each pool child; one, since two children with two threads each took 8 times as long.
        pipeline: Dotted path of the function that runs a job.
        writer: Dotted path of the function that writes a recovery's files.
        checker: Dotted path of the function that refuses a bad scan or body at submission.
    """

    home: Path = Path("~/.local/share/garmentq")
    database_url: str = ""
    broker_url: str = ""
    store: Path | None = None
    lease_seconds: float = 30.0
    max_attempts: int = 3
    max_seconds: float = 3600.0
    poll_seconds: float = 0.5
    republish_seconds: float = 20.0
    grace_seconds: float = 10.0
    idle_seconds: float = 900.0
    log_json: int = 0
    threads: int = 1
    pipeline: str = PIPELINE
    writer: str = WRITER
    checker: str = CHECKER

    def find(self, part: str) -> Callable[..., Any]:
        """Import the function that one of the dotted paths names, `package.module:function`."""
        module, _, name = getattr(self, part).partition(":")
        function: Callable[..., Any] = getattr(import_module(module), name)
        return function

    @property
    def database(self) -> str:
        """Give the database address that is really used."""
        return self.database_url or f"sqlite:///{self.home / 'garmentq.db'}"

    @property
    def store_path(self) -> Path:
        """Give the artifact folder that is really used."""
        return self.store or self.home / "store"

    @property
    def is_embedded(self) -> bool:
        """Tell whether the broker is our own."""
        return not self.broker_url

    def as_environment(self) -> dict[str, str]:
        """Give the variables that make another process read these very settings."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {f"GARMENTQ_{name.upper()}": "" if value is None else str(value) for name, value in values.items()}


def read_settings(environment: Mapping[str, str] | None = None, home: Path | str | None = None) -> ServiceSettings:
    """Read the settings from the environment; `home` wins over `GARMENTQ_HOME`.

    Raises:
        ServiceSettingBad: where a number is none, or is not positive.
    """
    environment = os.environ if environment is None else environment
    settings = ServiceSettings()
    for item in fields(ServiceSettings):
        text = environment.get(f"GARMENTQ_{item.name.upper()}", "")
        if text:
            settings = replace(settings, **{item.name: _parse(item.name, text, getattr(settings, item.name))})
    chosen = Path(home) if home else settings.home
    return replace(settings, home=chosen.expanduser().absolute())


def _parse(name: str, text: str, default: object) -> Any:
    if name in ("home", "store"):
        return Path(text).expanduser().absolute()
    if not isinstance(default, int | float):
        return text
    kind = type(default)
    try:
        value = kind(text)
    except ValueError:
        raise ServiceSettingBad(f"GARMENTQ_{name.upper()} is '{text}', which is no number.") from None
    if not 0 <= value < float("inf") or (value == 0 and name not in ("idle_seconds", "log_json")):
        raise ServiceSettingBad(f"GARMENTQ_{name.upper()} is '{text}'; it must be a positive number.")
    return value


def hide_password(url: str) -> str:
    """Give an address that may be shown: its password replaced by stars."""
    parts = urlsplit(url)
    if parts.password is None:
        return url
    host = parts.netloc.rsplit("@", 1)[1]
    return urlunsplit(parts._replace(netloc=f"{parts.username or ''}:***@{host}"))
