"""`garmentq courier`: sends webhook messages where workers have no outgoing network access."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import click

from .options import home_option


@click.command("courier")
@click.option("--check", "is_check", is_flag=True, help="Only check that one runs in this home; status 9: none does.")
@home_option
def command(is_check: bool, home: Path | None) -> None:
    """Send webhook messages until stopped.

    Workers do so themselves. If they cannot reach the addresses, set GARMENTQ_SEND_MESSAGES=0 for them, and run this on
    a host or in a container that can: it needs the database and outgoing network access. Several share the messages.

    \b
    Example:
      garmentq courier
    """
    from ..service.settings import read_settings
    from ..workers.alive import Kept, check_heartbeat

    settings = read_settings(home=home)
    if is_check:
        check_heartbeat(settings, Kept.COURIER)
        return
    from ..service.logs import set_up_logs
    from ..workers.courier import run_courier

    set_up_logs(bool(settings.log_json))
    with suppress(KeyboardInterrupt):
        run_courier(settings)
