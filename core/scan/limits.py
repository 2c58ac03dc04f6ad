"""How much one file may cost."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Bound what reading one file may use.

    Attributes:
        file_bytes: Largest file [bytes]; 512 MiB is an ASCII PLY of about 8 million vertices, far above any garment.
        count: Largest number of any one kind of element; 20 million keeps the arrays below 1 GB.
        memory_bytes: Address space of the parsing process [bytes]; 4 GiB holds the largest file several times over.
        cpu_seconds: CPU time of the parsing process [s]; an 80K-vertex scan takes about 1.
        output_bytes: Largest file the parsing process may write [bytes].
        wall_seconds: Time after which the parsing process is killed [s], for one that sleeps instead of computing.
    """

    file_bytes: int = 512 * 1024**2
    count: int = 20_000_000
    memory_bytes: int = 4 * 1024**3
    cpu_seconds: int = 120
    output_bytes: int = 2 * 1024**3
    wall_seconds: float = 240.0
