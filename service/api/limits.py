"""Limits of one request and of one key."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from ..settings import ServiceSettingBad
from ..uploads import UploadBounds

PREFIX = "GARMENTQ_API_"
"""Beginning of a limit's variable: GARMENTQ_API_UPLOAD_BYTES and so on."""


@dataclass(frozen=True)
class ApiLimits:
    """Describe the limits of requests. Those by key, except streams, do not apply to the local user without keys.

    Each API process counts rates, uploads, downloads and streams for itself; the bytes of a day and the jobs are
    counted in the database.

    Attributes:
        upload_bytes: Largest upload [bytes]; 512 MiB as for files on disk (`core.scan.limits.Limits`).
        body_bytes: Largest JSON body [bytes]; a job's request is below 2 kB, a question for 1000 jobs 15 kB.
        template_bytes: Largest pattern file [bytes]; a GarmentCode pattern is below 100 kB.
        chunk_seconds: Longest silence of a client that sends [s]; a phone network pauses for a few seconds.
        upload_seconds: Longest time of one upload [s]; 512 MiB at 1 MB/s.
        answer_seconds: Longest time until a response begins [s]; the largest upload is copied and hashed in a few
            seconds.
        streams: Event streams that one key may have open; each reads the database twice a second.
        requests_per_second: Requests of one key in the long run [1/s]; `garmentq submit` of a folder sends about 20 a
            second, and a core answers about 200.
        burst: Requests of one key at once, after a silence; a page that shows a result and its files sends 20.
        uploads: Uploads of one key at a time; fifty were measured within 300 MB of memory.
        downloads: Downloads of one key at a time; a browser opens six at once, each holds a file and 1 MiB of memory.
        stalled_seconds: Longest time that a response may stay unread [s]; a phone network pauses for a few seconds. A
            client that reads slowly but steadily is not cut off.
        head_seconds: Longest time until a request's head is complete [s]; a phone network takes less than one.
        connections_per_address: Connections that one address may have open. A proxy is one address: it needs as many as
            it has clients, up to `server.MAX_CONCURRENT_REQUESTS`.
        wrong_keys: Wrong keys that one address may try at once; one more each 10 s.
        body_seconds: Longest time until a body that is not an upload is complete [s]; 4 MiB at 150 kB/s.
        limited: Limited processes at a time, of all keys: each takes a core for some seconds, and 60 MB to 4 GiB.
        limited_per_key: Limited processes of one key at a time; others wait for their turn.
        limited_waiting: Requests of one key that wait for their turn; a page that compares or edits sends two or three.
        limited_wait_seconds: Longest time that they wait [s]; a pattern of six panels is checked in 1.
        day_bytes: Bytes of the files that one key uploads in 24 hours; a studio's 1000 scans of 20 MB are 20 GB.
        day_files: Files that one key uploads in 24 hours; a studio's 1000 scans with a body and labels each are 3000.
        files: Uploads of one key that are stored; each is a file and a row, until it is deleted or its retention ends.
    """

    upload_bytes: int = 512 * 1024**2
    body_bytes: int = 64 * 1024
    template_bytes: int = 4 * 1024**2
    chunk_seconds: float = 30.0
    upload_seconds: float = 600.0
    answer_seconds: float = 120.0
    streams: int = 32
    requests_per_second: float = 50.0
    burst: int = 200
    uploads: int = 50
    downloads: int = 32
    stalled_seconds: float = 30.0
    head_seconds: float = 10.0
    connections_per_address: int = 200
    wrong_keys: int = 20
    body_seconds: float = 30.0
    limited: int = 3
    limited_per_key: int = 1
    limited_waiting: int = 8
    limited_wait_seconds: float = 10.0
    day_bytes: int = 64 * 1024**3
    day_files: int = 10_000
    files: int = 1_000_000

    @property
    def upload_bounds(self) -> UploadBounds:
        """Return what one key may upload."""
        return UploadBounds(self.day_bytes, self.day_files, self.files)


def read_limits(environment: Mapping[str, str] | None = None) -> ApiLimits:
    """Read the limits from the environment, each from `GARMENTQ_API_` + NAME.

    Raises:
        ServiceSettingBad: if a value is not a positive number.
    """
    environment = os.environ if environment is None else environment
    chosen: dict[str, Any] = {}
    default = ApiLimits()
    for field in fields(ApiLimits):
        name = PREFIX + field.name.upper()
        text = environment.get(name, "")
        if not text:
            continue
        try:
            value = type(getattr(default, field.name))(text)
        except ValueError:
            raise ServiceSettingBad(f"{name} is '{text[:80]}', which is not a number.") from None
        if not 0 < value < float("inf"):
            raise ServiceSettingBad(f"{name} is '{text[:80]}'; it must be a positive number.")
        chosen[field.name] = value
    return ApiLimits(**chosen)
