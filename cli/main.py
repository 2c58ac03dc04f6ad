"""The command `garmentq`: each sub-command is a module of its own, imported only when it is used."""

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
    "run": "Recover a garment: submit its scan, run the job here, wait, and show the result.",
    "submit": "Queue one or more scans.",
    "dress": "Dress another body in a stored result, or in all garments of a person.",
    "refit": "Fit a stored result to another body's measures.",
    "refine": "Recover a preview's garment at standard quality.",
    "edit": "Drape an edited pattern of a stored result.",
    "animate": "Move a stored result with its wearer.",
    "status": "Show the jobs, or one of them.",
    "logs": "Show the events of a job.",
    "result": "Show a job's result.",
    "export": "Copy a job's files into a folder, or write its garment in another format.",
    "share": "Make a link that shows one result to whoever has it.",
    "sizes": "Grade a result's pattern to other sizes.",
    "query": "Search completed jobs by their results.",
    "measure": "Measure a body, a pattern, or a job's garment and wearer.",
    "match": "Compare two patterns panel by panel.",
    "cancel": "Stop a job.",
    "rename": "Give a job's family another name or tags.",
    "retry": "Queue ended jobs again.",
    "subjects": "List, show, create, update and delete subjects: the persons who were scanned.",
    "priority": "Change the priority of jobs.",
    "segment": "Label skin, hair, shoes and garments of a person's scan, and fit the body under the clothes.",
    "inspect": "Show what is detected in a file, before a job is run.",
    "templates": "List, show, import, export and delete template patterns.",
    "bodies": "List the built-in bodies, and write a body as a mesh or by its parameters.",
    "materials": "List, show, import, export and delete fabrics.",
    "worker": "Run a worker until stopped.",
    "courier": "Send webhook messages until stopped.",
    "serve": "Serve the HTTP API and its pages until stopped.",
    "keys": "Create, list, rotate and revoke API keys.",
    "webhooks": "Create, list, rotate, delete and test webhooks, which receive messages when jobs end.",
    "audit": "Show changes, downloads and deletions over HTTP.",
    "up": "Start the embedded broker and worker.",
    "down": "Stop the embedded worker and broker; the jobs stay.",
    "db": "Upgrade the database's tables.",
    "delete": "Delete ended jobs with their files.",
    "gc": "Delete stored files that no job names.",
    "backup": "Save the database and its files into one tar file.",
    "verify": "Check that every stored file exists and is undamaged.",
    "archive": "Save ended jobs with their files into one tar file, and delete them if asked.",
    "restore": "Restore a backup into a home or a server's database.",
    "doctor": "Check that everything garmentq needs is available.",
    "bench": "Recover every target pack in a folder and compare with the truth.",
    "completion": "Print the completion script of a shell.",
    "man": "Print the manual page of all commands.",
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
    "archive",
    "delete",
    "gc",
    "backup",
    "verify",
    "restore",
)
"""Commands that work on a home of this machine, and are refused if GARMENTQ_URL names a service."""


class LazyGroup(click.Group):
    """List the commands without importing them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of use."""
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
        """Find the command that was typed; for an unknown one the error names the closest match."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            if similar := get_close_matches(args[0], COMMANDS, n=1):
                raise click.UsageError(f"{error.message} Did you mean `garmentq {similar[0]}`?", error.ctx) from None
            raise

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands from `COMMANDS`."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


def _refusing(command: click.Command) -> click.Command:
    """Return the command with its help, but with a callback that refuses."""
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
    """Refuse an argument that is not UTF-8, unless it names an existing file: it cannot be stored or sent.

    Raises:
        TextBad: if there is one.
    """
    for word in words:
        if has_unstorable_text(word) and not os.path.lexists(word.partition("=")[2] if word.startswith("-") else word):
            raise TextBad()


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error of ours is printed as one line, without a traceback."""
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
    except OSError as error:  # an unreadable path, a full disk: errors without a code
        from .output import FileUnusable
        from .terminal import print_error

        print_error(FileUnusable.code, f"{error}; check the path, its permissions and the free space on its disk.")
        status = exits.BAD_INPUT
    sys.exit(status if isinstance(status, int) else exits.OK)


if __name__ == "__main__":
    main()
