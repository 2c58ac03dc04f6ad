"""Confirmation of a deletion."""

from __future__ import annotations

import sys

import click

from ..core.run.errors import Cancelled, GarmentqError


class ConfirmationMissing(GarmentqError):
    """A deletion has to be confirmed, and there is no terminal to ask; repeat the command with --yes."""

    code = "command.unconfirmed"


class DeletionDeclined(Cancelled):
    """The deletion was not confirmed; nothing was deleted."""

    code = "command.declined"


def confirm_deletion() -> None:
    """Ask for the confirmation of what was listed.

    Raises:
        ConfirmationMissing: if standard input ends without an answer and is no terminal.
        DeletionDeclined: if the answer is no.
    """
    try:
        is_confirmed = click.confirm("Delete all of these? This cannot be undone.", err=True)
    except click.Abort as error:
        if not isinstance(error.__context__, EOFError) or sys.stdin.isatty():
            raise
        click.echo(err=True)  # ends the line of the question
        raise ConfirmationMissing() from None
    if not is_confirmed:
        raise DeletionDeclined()
