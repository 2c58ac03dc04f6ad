"""Settings of the service, read from the environment."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from ..core.run.errors import BadInput

__all__ = ["ServiceSettingBad", "ServiceSettings", "read_settings"]

PIPELINE = "garmentq.core.recover.pipeline:recover"
"""Function that runs a recovery. Tests of the queue replace it."""

WRITER = "garmentq.core.deliver.export.result:write_recovery"
"""Function that writes the files of a recovery."""

CHECKER = "garmentq.service.checking:check_recovery"
"""Function that reads and checks the files of a recovery first, in a limited process."""

SEPARATOR = "garmentq.service.kinds.person_work:segment_person"
"""Function that segments a person."""

PERSON_CHECKER = "garmentq.service.checking:check_person"
"""Function that reads and checks the files of a person first, in a limited process."""


class ServiceSettingBad(BadInput):
    """A GARMENTQ_ environment variable has a value that cannot be used; see docs/reference/settings.md."""

    code = "service.setting_bad"


@dataclass(frozen=True)
class ServiceSettings:
    """Describe where data is stored and the limits of time and memory; each field is read from `GARMENTQ_` + NAME.

    Attributes:
        home: Folder of the embedded database, broker, store and logs; the XDG data folder, so that no root is needed.
        database_url: SQLAlchemy address; empty: SQLite in `home`, which needs no server.
        broker_url: Redis or Valkey address; empty: an embedded Valkey, started on demand.
        store: Folder of the artifacts, or `s3://bucket/prefix`; empty: `home/store`. The bucket's keys are read as by
            every S3 program: from AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or AWS_SHARED_CREDENTIALS_FILE.
        s3_endpoint: Address of an S3 server that is not Amazon's, such as `http://store:3900`; empty: Amazon's.
        lease_seconds: Validity of a claim without a heartbeat [s]. 30 s is three missed heartbeats of a busy machine; a
            crash costs at most this and the work since the last checkpoint.
        max_attempts: Claims of one job before it ends as `dead`; a third crash in a row is not by chance.
        max_seconds: Longest time of one attempt [s]; an ordinary job takes one to two minutes.
        poll_seconds: Period of the dispatcher and of the cancel check [s]; half a second is not noticeable.
        republish_seconds: Time without an event after which a queued job is published again [s] if the broker has no
            message: it must have lost it. A needless message does no harm.
        grace_seconds: Time that a job has to stop [s]: after half of it its code is interrupted, then its process is
            ended. A stage checks several times a
            second, and containers are killed after 10 to 30 s.
        idle_seconds: Time without a job after which the embedded worker and broker stop [s]; 0: never.
        job_memory_mb: Largest memory of a job's process [MB]; 0: unlimited. An ordinary job takes 700. One that needs
            more ends as failed; without a limit the system might kill any process.
        pause_seconds: First pause of a job that met an unavailable or full store [s]; each next one is twice as long,
            up to `outage.MAX_OUTAGE_PAUSE`.
        free_bytes: Free space that the store's disk must have to start a job or accept an upload [bytes]; a job stores
            about 20 MB, an upload is at most 512 MiB.
        share_jobs: 1: equal orders of different API keys are one job, which each of them sees; 0: a job for each.
        webhook_networks: Networks that webhooks may reach beyond the public internet, such as `10.1.0.0/16`, separated
            by commas; empty: none. It is checked when a webhook is created and when a message is sent.
        send_messages: 1: workers send webhook messages; 0: they leave it to `garmentq courier`, if they have no
            outgoing network access.
        keep_days: Days after a family's end after which it is deleted; 0: never.
        keep_tag_days: The same for families with a tag, `trial=7,2026-11=365`; empty: none. A subject's own retention
            counts before these, and these before `keep_days`.
        log_json: 1: workers, couriers and the API write their logs as one JSON object a line.
        threads: Threads of each pool child; one, because two children with two threads each took 8 times as long.
        pipeline: Dotted path of the function that runs a recovery.
        writer: Dotted path of the function that writes a recovery's files.
        kinds: Dotted paths of the classes of further kinds of jobs, `package.module:Class`, separated by commas.
        checker: Dotted path of the function that reads and checks a recovery's files, in a limited process.
        separator: Dotted path of the function that segments a person and writes the result.
        person_checker: Dotted path of the function that reads and checks a person's files, in a limited process.
    """

    home: Path = Path("~/.local/share/garmentq")
    database_url: str = ""
    broker_url: str = ""
    store: str = ""
    s3_endpoint: str = ""
    lease_seconds: float = 30.0
    max_attempts: int = 3
    max_seconds: float = 3600.0
    poll_seconds: float = 0.5
    republish_seconds: float = 20.0
    grace_seconds: float = 10.0
    idle_seconds: float = 900.0
    job_memory_mb: int = 8192
    pause_seconds: float = 2.0
    free_bytes: int = 512 * 1024**2
    share_jobs: int = 0
    webhook_networks: str = ""
    send_messages: int = 1
    keep_days: float = 0.0
    keep_tag_days: str = ""
    log_json: int = 0
    threads: int = 1
    pipeline: str = PIPELINE
    writer: str = WRITER
    checker: str = CHECKER
    separator: str = SEPARATOR
    person_checker: str = PERSON_CHECKER
    kinds: str = ""

    def find(self, part: str) -> Callable[..., Any]:
        """Import the function of one of the dotted paths, `package.module:function`."""
        module, _, name = getattr(self, part).partition(":")
        function: Callable[..., Any] = getattr(import_module(module), name)
        return function

    @property
    def database(self) -> str:
        """Return the address of the database."""
        return self.database_url or f"sqlite:///{self.home / 'garmentq.db'}"

    @property
    def store_path(self) -> Path:
        """Return the folder of the artifacts; an S3 store has none."""
        return Path(self.store) if self.store and not self.is_store_remote else self.home / "store"

    @property
    def is_store_remote(self) -> bool:
        """Return whether the artifacts are in a bucket."""
        return self.store.startswith("s3://")

    @property
    def is_database_server(self) -> bool:
        """Return whether the database is a server's, which several hosts may share, instead of a file."""
        return bool(self.database_url) and not self.database_url.startswith("sqlite")

    @property
    def is_embedded(self) -> bool:
        """Return whether the broker is the embedded one."""
        return not self.broker_url

    @property
    def tag_days(self) -> dict[str, float]:
        """Return the retention of each tag that has one [d]; infinity for 0: its jobs are never deleted.

        Raises:
            ServiceSettingBad: if the setting is not `TAG=DAYS,...`.
        """
        found: dict[str, float] = {}
        for part in filter(None, (one.strip() for one in self.keep_tag_days.split(","))):
            tag, _, text = part.rpartition("=")
            if not tag or not re.fullmatch(r"\d{1,5}(\.\d+)?", text):
                raise ServiceSettingBad(f"GARMENTQ_KEEP_TAG_DAYS has '{part[:80]}'; write TAG=DAYS,TAG=DAYS.")
            found[tag] = float(text) or float("inf")
        return found

    def as_environment(self) -> dict[str, str]:
        """Return the environment variables by which another process reads the same settings."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {f"GARMENTQ_{name.upper()}": "" if value is None else str(value) for name, value in values.items()}


def read_settings(environment: Mapping[str, str] | None = None, home: Path | str | None = None) -> ServiceSettings:
    """Read the settings from the environment; `home` overrides `GARMENTQ_HOME`.

    `GARMENTQ_DATABASE_URL_FILE` and the like name a file with the value, so that a container's environment does not
    show a secret. The plain variable has precedence.

    Raises:
        ServiceSettingBad: if a number is invalid or not positive, or a named file cannot be read.
    """
    environment = os.environ if environment is None else environment
    settings = ServiceSettings()
    for item in fields(ServiceSettings):
        text = _find_text(environment, f"GARMENTQ_{item.name.upper()}")
        if text:
            settings = replace(settings, **{item.name: _parse(item.name, text, getattr(settings, item.name))})
    _ = settings.tag_days  # refused here, and not in a worker's first hour
    chosen = Path(home) if home else settings.home
    return replace(settings, home=chosen.expanduser().absolute())


MAY_BE_ZERO = ("idle_seconds", "keep_days", "log_json", "share_jobs", "send_messages", "free_bytes", "job_memory_mb")


def _find_text(environment: Mapping[str, str], name: str) -> str:
    text, file = environment.get(name, ""), environment.get(f"{name}_FILE", "")
    if text or not file:
        return text
    try:
        return Path(file).read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError):
        raise ServiceSettingBad(f"{name}_FILE names '{file}', which cannot be read.") from None


def _parse(name: str, text: str, default: object) -> Any:
    if name == "home":
        return Path(text).expanduser().absolute()
    if name == "store":
        return text if "://" in text else str(Path(text).expanduser().absolute())
    if not isinstance(default, int | float):
        return text
    kind = type(default)
    try:
        value = kind(text)
    except ValueError:
        raise ServiceSettingBad(f"GARMENTQ_{name.upper()} is '{text}', which is not a number.") from None
    if not 0 <= value < float("inf") or (value == 0 and name not in MAY_BE_ZERO):
        raise ServiceSettingBad(f"GARMENTQ_{name.upper()} is '{text}'; it must be a positive number.")
    return value


SECRET_WORDS = ("password", "passwd", "pwd", "secret", "token", "key")
"""Parts of the names of address parameters whose value is hidden."""


def hide_password(url: str) -> str:
    """Return an address for display: its password, and parameters that sound like one, are replaced by stars.

    A password may contain characters that an address may not, such as `/`, `#`, `?` or `@`, which programs accept
    nevertheless. So everything from the first colon of the host's part to the last `@` is hidden.
    """
    url = re.sub(r"^([a-z0-9+]+://[^:/@]*):.*@", r"\1:***@", url, flags=re.IGNORECASE | re.DOTALL)
    words = "|".join(SECRET_WORDS)
    return re.sub(rf"([?&][^=&]*(?:{words})[^=&]*=)[^&#]+", r"\1***", url, flags=re.IGNORECASE)


def show_settings(settings: ServiceSettings) -> dict[str, str]:
    """Return every setting as text for display, without passwords and keys."""
    return {name: hide_password(value) for name, value in settings.as_environment().items()}
