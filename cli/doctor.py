"""`garmentq doctor`."""

from __future__ import annotations

from pathlib import Path

import click

from . import exits
from .options import home_option, json_option


@click.command("doctor")
@home_option
@click.option(
    "--worker",
    "needs_worker",
    is_flag=True,
    help="Check that a worker of this machine is alive, and leave out kernels.",
)
@click.option("--warm", is_flag=True, help="Only compile the kernels that are not compiled for this processor yet.")
@click.option("--all", "is_all", is_flag=True, help="Show the settings that have their default, too.")
@json_option
@click.pass_context
def command(
    context: click.Context, home: Path | None, needs_worker: bool, warm: bool, is_all: bool, as_json: bool
) -> None:
    """Check that everything garmentq needs is available.

    Failed checks come first, then warnings. Starts nothing, and changes nothing without --warm. Passwords are not
    shown. The exit status is 1 if a check failed. `garmentq worker --check` is a light check of a running worker.

    \b
    Example:
      garmentq doctor
      garmentq doctor --warm
    """
    from ..service.settings import read_settings
    from .doctor_checks import Level, compile_kernels, examine
    from .terminal import print_json, print_note, print_table

    settings = read_settings(home=home)
    found = list(compile_kernels() if warm else examine(settings, needs_worker, home is not None))
    found.sort(key=lambda one: list(Level).index(one.level))
    has_failed = any(one.level is Level.FAIL for one in found)
    if as_json:
        for one in found:
            passed = one.level is not Level.FAIL
            print_json({"check": one.check, "ok": passed, "level": one.level, "message": one.message})
    else:
        shown = [one for one in found if is_all or not one.is_default]
        print_table(["check", "", ""], [[one.check, one.level, one.message] for one in shown])
        if len(shown) < len(found):
            print_note(f"{len(found) - len(shown)} settings have their default; `garmentq doctor --all` shows them")
    context.exit(exits.FAULT if has_failed else exits.OK)
