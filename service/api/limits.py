"""What one request may cost."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ApiLimits:
    """Bound requests.

    Attributes:
        upload_bytes: Largest upload [bytes]; 512 MiB as for files on disk (`core.scan.Limits`).
        body_bytes: Largest JSON body [bytes]; a job's request is below 2 kB.
        template_bytes: Largest pattern file [bytes]; a GarmentCode pattern is below 100 kB.
        chunk_seconds: Longest silence of a client that sends [s]; a phone network pauses for a few seconds.
        upload_seconds: Longest time of one upload [s]; 512 MiB at 1 MB/s.
        answer_seconds: Longest time until an answer begins [s]; a large scan is checked in about 30 s.
        checks: Scans checked at a time; each runs a parsing process and holds its arrays.
        streams: Event streams that one key may hold open; each asks the database twice a second.
    """

    upload_bytes: int = 512 * 1024**2
    body_bytes: int = 64 * 1024
    template_bytes: int = 4 * 1024**2
    chunk_seconds: float = 30.0
    upload_seconds: float = 600.0
    answer_seconds: float = 120.0
    checks: int = 2
    streams: int = 32
