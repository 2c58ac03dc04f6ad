"""Names are hostile: nothing in them moves a cursor, begins a line, runs in a spreadsheet, or leads out of a folder."""

from __future__ import annotations

import csv
import io
import logging
import sys

import pytest
from garmentq.cli.terminal import print_csv, print_table
from garmentq.core.run.errors import GarmentqError
from garmentq.service.connection import Connection
from garmentq.service.logs import PlainLines
from garmentq.service.records import Artifact
from garmentq.service.remote import RemoteBackend
from garmentq.service.store import ArtifactDamaged
from garmentq.service.submission import clean_name
from hypothesis import given
from hypothesis import strategies as st

EVIL = "a\x1b[2J\x1b]0;x\x07\r\n2026-01-01 00:00:00,000 INFO fake\u202e\x9b31m.ply"
CONTROLS = {chr(code) for code in [*range(32), *range(127, 160)]} - {"\n"} | {"\u202e", "\u2028"}


def test_a_table_for_a_spreadsheet_has_no_formula(capsys):
    """Broken where a cell or a column's name runs when the file is opened, or a number becomes text."""
    starts = ["=1+1", "+1", "-1", "@SUM(1)", "|x", "\t=1", "  =1", "\r\n=1", "\uff1d1", "\uff0b1", "\uff0d1", "\uff201"]
    print_csv(["job", "=HYPERLINK(1)"], [[text, -1.5] for text in starts])
    rows = list(csv.reader(io.StringIO(capsys.readouterr().out)))
    assert len(rows) == len(starts) + 1 and rows[0][1].startswith("'=")
    for row in rows[1:]:
        assert row[0].startswith(("'", "?")) and row[1] == "-1.5", row


def test_no_name_reaches_the_terminal_as_it_is(cli, capsys, tmp_path):
    """Broken where a file's name, a table's title or an error's text carries an escape, or begins a line of its own."""
    path = tmp_path / EVIL.replace("\n", "_")
    path.write_text("no mesh")
    for words in (("submit", path, "--body", path), ("inspect", path), ("templates", "import", path, "--name", EVIL)):
        done = cli(*words)
        assert done.returncode in (2, 4), (words, done)
        assert not CONTROLS & set(done.stdout + done.stderr), (words, done.stderr)
    for words in (("status", EVIL), ("templates", "show", EVIL), ("materials", EVIL), ("query", "--where", EVIL)):
        done = cli(*words)
        assert done.returncode in (2, 3), (words, done)
        assert not CONTROLS & set(done.stderr) and len(done.stderr.splitlines()) == 1, (words, done.stderr)
    print_table([EVIL, "b"], [[EVIL, 1], ["[red]x[/red]", 2]], title="[bold]" + EVIL)
    shown = capsys.readouterr().out
    assert not CONTROLS & set(shown) and "[red]x[/red]" in shown and "[bold]" in shown


def test_a_log_has_one_beginning_for_each_record():
    """Broken where a name in a message looks like a record of its own, or clears the operator's screen."""
    try:
        raise GarmentqError(EVIL)
    except GarmentqError:
        record = logging.LogRecord("x", logging.INFO, "", 0, "job %s: %s", ("1", EVIL), sys.exc_info())
    text = PlainLines("%(asctime)s %(levelname)s %(message)s").format(record)
    assert not CONTROLS & set(text)
    assert all(line.startswith("    ") for line in text.splitlines()[1:]) and len(text.splitlines()) > 3


@given(st.text(max_size=300))
def test_a_cleaned_name_is_a_plain_file_name(name):
    """Broken where some name becomes a folder, a hidden file, an option, or more than a file system takes."""
    cleaned = clean_name(name)
    assert 0 < len(cleaned) <= 100 and cleaned.isascii() and "/" not in cleaned and not cleaned.startswith((".", "-"))
    assert clean_name(cleaned) == cleaned


@pytest.mark.parametrize("name", ["../x", "/etc/x", "a/../../x", "a\\x", "a//x", "", ".", "a\x00", "a\x1b[2J", "a\n"])
def test_a_service_cannot_write_elsewhere(name, tmp_path, monkeypatch):
    """Broken where a file that a hostile service names lands outside of the folder, or its name in the terminal."""
    asked = []
    monkeypatch.setattr(Connection, "stream", lambda *given: asked.append(given))
    with RemoteBackend("http://127.0.0.1:1") as client, pytest.raises(ArtifactDamaged):
        client._download("3685ecfd4f81", Artifact(name, "0" * 64, 1), tmp_path / "out")
    assert not asked and not (tmp_path / "out").exists()


@pytest.mark.parametrize("job", ["../../x", "a\x1b[2J", "", "x" * 40, "é"])
def test_a_service_cannot_name_a_job_as_it_likes(job, monkeypatch):
    """Broken where an id that a hostile service gives is printed, or becomes part of a path."""
    monkeypatch.setattr(Connection, "request", lambda *given, **more: {"job": job, "error": None})
    with RemoteBackend("http://127.0.0.1:1") as client, pytest.raises(GarmentqError) as error:
        client.find_job("abcd")
    assert error.value.code == "service.unreachable"
