"""The command `garmentq`: each sub-command is a module of its own, imported only when it is asked for."""

from __future__ import annotations

import importlib
import os
import sys
from copy import copy
from difflib import get_close_matches

import click

from .. import __version__
from ..core.run.errors import GarmentqError
from ..core.run.text import TextBad, has_unstorable_text
from . import exits
from .output import keep_mask
from .signals import interrupt_on_stop_signals

COMMANDS = {
    "run": "Recover a garment: submit it, work on it here, wait, and show the result.",
    "submit": "Queue one or more scans.",
    "dress": "Dress another body in a stored result, or in all garments of a person.",
    "refit": "Make a stored result to another body's measures.",
    "edit": "Drape an edited pattern of a stored result.",
    "animate": "Move a stored result with its wearer.",
    "status": "Show the jobs, or one of them.",
    "logs": "Show what happened to a job.",
    "result": "Show what a job found.",
    "export": "Copy a job's files into a folder, or write its garment in another format.",
    "sizes": "Grade a result's pattern to other sizes.",
    "query": "Search completed jobs by their results.",
    "match": "Compare two patterns panel by panel.",
    "cancel": "Stop a job.",
    "retry": "Queue ended jobs again.",
    "segment": "Separate skin, hair, shoes and garments of a person's scan, and find the body under the clothes.",
    "inspect": "Show how a file is understood, before anything is run.",
    "templates": "List, show, import, export and delete template patterns.",
    "bodies": "List the built-in bodies, and write one as a mesh.",
    "materials": "List, show, import, export and delete fabrics.",
    "worker": "Run a worker until it is told to stop.",
    "courier": "Send what is owed to webhooks until told to stop.",
    "serve": "Serve the HTTP API and its pages until told to stop.",
    "keys": "Make, list and revoke API keys.",
    "webhooks": "Make, list, delete and test addresses that are told when jobs end.",
    "audit": "Show who changed, took or deleted what over HTTP.",
    "up": "Start the embedded broker and worker.",
    "down": "Stop the embedded worker and broker; the jobs stay.",
    "db": "Bring the database's tables up to date.",
    "delete": "Delete ended jobs with their files.",
    "gc": "Remove stored files that no job names.",
    "backup": "Save the embedded database and its files into one tar file.",
    "verify": "Look whether every stored file is there and sound.",
    "restore": "Bring a backup back into a home.",
    "doctor": "Check that everything garmentq needs is there.",
    "bench": "Recover every target pack in a folder and compare with the truth.",
}
"""Every command with its line in `garmentq --help`; a test compares it with the command's own help."""


LOCAL_COMMANDS = (
    "worker",
    "courier",
    "serve",
    "audit",
    "up",
    "down",
    "db",
    "delete",
    "gc",
    "backup",
    "verify",
    "restore",
)
"""Commands that work on a home of this machine, and so not where GARMENTQ_URL names a service."""


class LazyGroup(click.Group):
    """List the commands without importing them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of a user's day."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one command."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(f".{cmd_name}", __package__).command
        return _refusing(command) if cmd_name in LOCAL_COMMANDS and os.environ.get("GARMENTQ_URL") else command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that was typed; of one that there is not the nearest name is told."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            if near := get_close_matches(args[0], COMMANDS, n=1):
                raise click.UsageError(f"{error.message} Did you mean `garmentq {near[0]}`?", error.ctx) from None
            raise

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands from `COMMANDS`."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


def _refusing(command: click.Command) -> click.Command:
    """Return the command with its help, but without what it does."""
    refused = copy(command)

    def refuse(*_: object, **__: object) -> None:
        from ..service.backend import LocalOnly

        raise LocalOnly(
            f"`garmentq {command.name}` works on a home of this machine; unset GARMENTQ_URL, or run it there."
        )

    refused.callback = refuse
    return refused


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "--version", prog_name="garmentq")
def group() -> None:
    """Recover a sewing pattern, a simulation mesh and a detailed mesh from the 3D scan of a garment.

    \b
    Example:
      garmentq run garment.ply --body body.ply
    """


def _refuse_text(words: list[str]) -> None:
    """Refuse an argument that is no UTF-8, unless it names a file that is there: nothing can keep it, or send it.

    Raises:
        TextBad: where there is one.
    """
    for word in words:
        if has_unstorable_text(word) and not os.path.lexists(word.partition("=")[2] if word.startswith("-") else word):
            raise TextBad()


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error of ours ends in one line, never in a traceback."""
    interrupt_on_stop_signals()
    try:
        _refuse_text(sys.argv[1:] if arguments is None else arguments)
        with keep_mask():
            status = group.main(args=arguments, prog_name="garmentq", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        status = error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        status = exits.DETACHED
    except GarmentqError as error:
        from .terminal import print_error

        print_error(error.code, error.message)
        status = exits.error_status(error)
    except BrokenPipeError:
        sys.stderr.close()
        status = exits.OK
    except OSError as error:  # a path that cannot be read, a full disk: whatever names no code itself
        from .output import FileUnusable
        from .terminal import print_error

        print_error(FileUnusable.code, f"{error}; check the path, its rights and the room on its disk.")
        status = exits.BAD_INPUT
    sys.exit(status if isinstance(status, int) else exits.OK)


if __name__ == "__main__":
    main()
