"""The manual page of all commands, as `man` reads it, from their own help."""

from __future__ import annotations

import re
from collections.abc import Iterator

import click

from .. import __version__
from . import exits

EXIT_STATUSES = (
    (exits.OK, "success"),
    (exits.FAULT, "a fault of garmentq"),
    (exits.USAGE, "the command line is wrong"),
    (exits.NOT_FOUND, "what was named does not exist"),
    (exits.BAD_INPUT, "an input cannot be used"),
    (exits.FAILED, "a job failed"),
    (exits.DEAD, "a job's workers died in every attempt"),
    (exits.CANCELLED, "a job was cancelled"),
    (exits.TIMED_OUT, "the time to wait is over"),
    (exits.UNREACHABLE, "a service does not respond"),
    (exits.FAILED_CHECK, "a result fails a check"),
    (exits.INCOMPLETE, "some files are missing or damaged"),
    (exits.DETACHED, "interrupted; the jobs continue"),
)
"""Statuses with what they mean; docs/reference/cli.md has them all."""


def format_manual_page(group: click.Group) -> str:
    """Return the page of a group of commands in roff, section 1.

    Args:
        group: The program's commands.
    """
    context = click.Context(group, info_name="garmentq")
    lines = [f'.TH GARMENTQ 1 "" "garmentq {__version__}"', ".SH NAME",
             f"garmentq \\- {_escape(group.get_short_help_str(200).rstrip('.'))}",
             ".SH SYNOPSIS", ".B garmentq", "\\fICOMMAND\\fR [\\fIOPTIONS\\fR] [\\fIARGUMENTS\\fR]",
             ".SH COMMANDS"]  # fmt: skip
    for path, command, inner in _walk(group, context):
        lines += _format_command(path, command, inner)
    lines.append(".SH EXIT STATUS")
    for status, meaning in EXIT_STATUSES:
        lines += [".TP", f".B {status}", _escape(meaning)]
    return "\n".join(lines) + "\n"


def _walk(group: click.Group, context: click.Context) -> Iterator[tuple[str, click.Command, click.Context]]:
    """Yield each command below a group with its words and its context."""
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        inner = click.Context(command, info_name=name, parent=context)
        if isinstance(command, click.Group):
            yield from _walk(command, inner)
        else:
            yield inner.command_path, command, inner


def _format_command(path: str, command: click.Command, context: click.Context) -> list[str]:
    """Return the paragraphs of one command: usage, text, example, options."""
    usage = " ".join([path, *command.collect_usage_pieces(context)])
    lines = [f".SS {_escape(path)}", ".nf", _escape(usage), ".fi"]
    for paragraph in re.split(r"\n\s*\n", command.help or ""):
        is_literal = paragraph.strip().startswith("\b")
        text = [_escape(line.strip() if not is_literal else line) for line in paragraph.replace("\b", "").splitlines()]
        text = [line for line in text if line.strip()]
        lines += [".PP", *([".nf", *text, ".fi"] if is_literal else text)]
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context) if isinstance(parameter, click.Option) else None
        if record is not None:
            lines += [".TP", f".B {_escape(record[0])}", _escape(record[1])]
    return lines


def _escape(text: str) -> str:
    """Return a text as roff takes it for letters."""
    plain = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + plain if plain.startswith((".", "'")) else plain
