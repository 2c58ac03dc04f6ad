"""What a shell and a manual know of the commands."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest
from click.testing import CliRunner
from garmentq.cli.main import COMMANDS, group
from garmentq.cli.manual_page import format_manual_page


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_gets_its_completion(shell):
    """Broken where the script asks for answers by another name than the program's."""
    answer = CliRunner().invoke(group, ["completion", shell])
    assert answer.exit_code == 0
    assert f"_GARMENTQ_COMPLETE={shell}_complete" in answer.output


def test_a_word_is_completed():
    """Broken where the program does not answer the script that it printed."""
    command = [sys.executable, "-m", "garmentq.cli.main"]
    asks = {"_GARMENTQ_COMPLETE": "bash_complete", "COMP_WORDS": "garmentq stat", "COMP_CWORD": "1"}
    answer = subprocess.run(command, env={**os.environ, **asks}, capture_output=True, text=True, check=True)
    assert answer.stdout.splitlines() == ["plain,status"]


def test_the_manual_has_every_command():
    """Broken where a command is missing, or a line begins with a dot that roff takes for a request."""
    page = format_manual_page(group)
    for name in COMMANDS:
        assert f".SS garmentq {name}" in page
    requests = {line.split()[0] for line in page.splitlines() if line.startswith(".")}
    assert requests == {".TH", ".SH", ".SS", ".B", ".PP", ".TP", ".nf", ".fi"}


@pytest.mark.skipif(shutil.which("groff") is None, reason="there is no groff")
def test_groff_reads_the_manual():
    """Broken where the page's requests are wrong."""
    command = ["groff", "-man", "-ww", "-Tutf8"]
    read = subprocess.run(command, input=format_manual_page(group), capture_output=True, text=True, check=True)
    assert read.stderr == ""
    assert "garmentq status" in read.stdout
