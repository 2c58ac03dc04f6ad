"""Open a stored result in a program: from a folder, from a job of a home, or from a service by its address."""

from __future__ import annotations

import os
import re
import tempfile
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from .backend import Backend, open_backend
from .derived import InputWrong
from .local_token import find_local_token
from .settings import ServiceSettings, read_settings

if TYPE_CHECKING:
    from ..core.deliver.export.stored_result import StoredResult

__all__ = ["open_result"]

PLACE = re.compile(
    r"^(?P<base>https?://[^/?#]+(?:/[^?#]*?)??)/(?:v1/jobs|jobs|results)/(?P<job>[0-9a-f]{4,16})(?:[/?#]|$)"
)
"""Addresses of a job: its route, or one of its pages."""


def open_result(source: str | Path, *, key: str | None = None, home: str | Path | None = None) -> StoredResult:
    """Open a garment's result.

    Args:
        source: A folder with a result's files; else a job's id or a beginning of it, in the home or, if GARMENTQ_URL is
            set, in that service; or a job's address, `http://host:8080/results/3685ecfd4f81` or
            `http://host:8080/v1/jobs/3685ecfd4f81`.
        key: Token of an API key. None: that of GARMENTQ_API_KEY, unless GARMENTQ_URL names another service than the
            address; else that of the home, for a service on this machine.
        home: The home; None: that of GARMENTQ_HOME.

    Returns:
        The result: `pattern`, `mesh("detail").vertices`, `fabric`, `body`, `metrics`, `plot()`.

    Raises:
        JobUnknown: if there is no such folder or job.
        InputWrong: if the job's result is not a garment.
        ResultOld: if it was stored by another version.
        ServiceUnreachable: if the service does not respond.
    """
    from ..core.deliver.export.stored_result import load_result

    text, settings = str(source), read_settings(home=home)
    if isinstance(source, Path) or Path(text).is_dir():
        return load_result(Path(source))
    if found := PLACE.match(text):
        from .remote import RemoteBackend

        token = find_key(found["base"], settings) if key is None else key
        with closing(RemoteBackend(found["base"], token)) as remote:
            return read_result(remote, found["job"])
    with closing(open_backend(settings)) as backend:
        return read_result(backend, text)


def find_key(url: str, settings: ServiceSettings) -> str:
    """Return the token for a service; a token for another service is not sent to it."""
    known = os.environ.get("GARMENTQ_URL", "")
    api_key = os.environ.get("GARMENTQ_API_KEY", "")
    if api_key and (not known or urlsplit(known)[:2] == urlsplit(url)[:2]):
        return api_key
    return find_local_token(url, settings.home)


def read_result(backend: Backend, job: str) -> StoredResult:
    """Read the result of a garment's job; only the files that are read are copied.

    Raises:
        InputWrong: if it is a person's, whose garments have jobs of their own.
    """
    from ..core.deliver.export.stored_result import FILES, load_result
    from ..core.reuse.wear.worn import WORN_FILE_NAME

    report = backend.find_job(job)
    names = {file.name for file in backend.list_artifacts(report.id)}
    if report.children and WORN_FILE_NAME not in names:
        below = ", ".join(f"{child.name} {child.job}" for child in report.children)
        raise InputWrong(f"job {report.id} is a job '{report.kind}'; open one of the jobs below it: {below}.")
    with tempfile.TemporaryDirectory(prefix="garmentq-result-") as folder:
        file_names = [name for name in FILES if name in names] or [WORN_FILE_NAME]
        backend.export_files(report.id, Path(folder), file_names)
        return load_result(Path(folder))
