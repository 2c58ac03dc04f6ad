"""`garmentq webhooks`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from . import exits
from .options import home_option, json_option

if TYPE_CHECKING:
    from ..service.backend import Backend


@click.group("webhooks")
def command() -> None:
    """Create, list, rotate, delete and test webhooks, which receive messages when jobs end.

    \b
    Example:
      garmentq webhooks create https://studio.example/garmentq
    """


@command.command("create")
@click.argument("url")
@click.option(
    "--on", "states", multiple=True, type=click.Choice(["succeeded", "failed", "dead", "cancelled"]),
    help="End state that it receives messages about; may be repeated.  [default: all]",
)  # fmt: skip
@home_option
@json_option
def create_command(url: str, states: tuple[str, ...], home: Path | None, as_json: bool) -> None:
    """Create a webhook for jobs that end from now on, and print its secret.

    The secret signs the messages; it is shown only now. Over HTTP it receives messages about the key's own jobs, on a
    home about all jobs.

    \b
    Example:
      garmentq webhooks create https://studio.example/garmentq --on succeeded --on failed
    """
    from ..service.states import State
    from .terminal import print_json, print_note

    webhook, secret = _open(home).create_webhook(url, [State(state) for state in states])
    if as_json:
        print_json(webhook.as_json() | {"secret": secret})
        return
    print_note(f"webhook {webhook.id} for {webhook.url}: {', '.join(webhook.states)}; its secret is not shown again")
    click.echo(secret)


@command.command("list")
@home_option
@json_option
def list_command(home: Path | None, as_json: bool) -> None:
    """List the webhooks, the outcome of the latest message, and the number of unsent messages.

    \b
    Example:
      garmentq webhooks list
    """
    from .terminal import print_json, print_table, show_time

    found = _open(home).list_webhooks()
    if as_json:
        for one in found:
            print_json(one.as_json())
        return
    print_table(
        ["webhook", "key", "url", "on", "latest", "status", "error", "unsent"],
        [
            [one.id, one.key, one.url, ", ".join(one.states), show_time(one.served), one.status, one.error, one.owed]
            for one in found
        ],
    )


@command.command("rotate")
@click.argument("webhook")
@click.option(
    "--hours",
    type=click.FloatRange(0, 168),
    default=24.0,
    show_default=True,
    help="Time for which the secret before stays.",
)
@home_option
@json_option
def rotate_command(webhook: str, hours: float, home: Path | None, as_json: bool) -> None:
    """Give a webhook a new secret, and print it; the one before signs messages too, for some hours.

    \b
    Example:
      garmentq webhooks rotate 5f1d0c9b7a3e
    """
    from .terminal import print_json, print_note, show_time

    rotated, secret = _open(home).rotate_secret(webhook, hours)
    if as_json:
        print_json(rotated.as_json() | {"secret": secret})
        return
    print_note(
        f"webhook {rotated.id} has a new secret, which is not shown again; "
        f"the one before signs until {show_time(rotated.earlier_until)}"
    )
    click.echo(secret)


@command.command("delete")
@click.argument("webhook")
@home_option
def delete_command(webhook: str, home: Path | None) -> None:
    """Delete a webhook and its unsent messages.

    \b
    Example:
      garmentq webhooks delete 5f1d0c9b7a3e
    """
    from .terminal import print_note

    _open(home).delete_webhook(webhook)
    print_note(f"webhook {webhook} is deleted")


@command.command("test")
@click.argument("webhook")
@home_option
@json_option
@click.pass_context
def test_command(context: click.Context, webhook: str, home: Path | None, as_json: bool) -> None:
    """Send a message of the type `test` now, and print the outcome; exit status 5 if it was not accepted.

    \b
    Example:
      garmentq webhooks test 5f1d0c9b7a3e
    """
    from dataclasses import asdict

    from .terminal import print_json, print_note

    receipt = _open(home).test_webhook(webhook)
    if as_json:
        print_json(asdict(receipt))
    else:
        print_note(f"answered {receipt.status}" if receipt.error is None else f"not accepted: {receipt.error}")
    context.exit(exits.OK if receipt.error is None else exits.FAILED)


def _open(home: Path | None) -> Backend:
    from ..service.backend import open_backend
    from ..service.settings import read_settings

    return open_backend(read_settings(home=home))
