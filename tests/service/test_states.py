"""The table of moves is the whole truth about a job's state, and one module writes it."""

from __future__ import annotations

import ast
from itertools import product
from pathlib import Path

import pytest
from garmentq.service.jobs import MoveForbidden, change_state, claim
from garmentq.service.models import JobRow
from garmentq.service.states import ENDED, OPEN, TRANSITIONS, UNSUCCESSFUL, State

ROOT = Path(__file__).parents[2]
WRITERS = ("values", "update", "insert", "write_fenced", "JobRow", "create")
"""Calls in which a keyword `state` writes a column."""


def find_writes(path: Path) -> list[int]:
    """Return the lines of a module that write a job's state."""
    lines = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        targets = {ast.Assign: "targets", ast.AugAssign: "target", ast.AnnAssign: "target"}.get(type(node))
        if targets is not None:
            found = getattr(node, targets)
            names = [part for one in (found if isinstance(found, list) else [found]) for part in ast.walk(one)]
            is_ours = any(isinstance(one, ast.Attribute) and one.attr == "state" and _is_row(one) for one in names)
            lines += [node.lineno] if is_ours else []
        if isinstance(node, ast.Call):
            called = getattr(node.func, "attr", getattr(node.func, "id", ""))
            is_set = called == "setattr" and any(isinstance(a, ast.Constant) and a.value == "state" for a in node.args)
            is_column = called in WRITERS and any(word.arg == "state" for word in node.keywords)
            lines += [node.lineno] if is_set or is_column else []
    return lines


def _is_row(node: ast.Attribute) -> bool:
    """Distinguish an attribute that is stored from one that is read on the way to another (`app.state.rooms = ...`)."""
    return isinstance(node.ctx, ast.Store)


def test_one_module_writes_states():
    """Broken where a state is written past the table of moves: two truths of how a job may go."""
    modules = [path for layer in ("service", "workers", "cli") for path in (ROOT / layer).rglob("*.py")]
    wrong = {str(path.relative_to(ROOT)): find_writes(path) for path in modules if path.name != "jobs.py"}
    assert {name: lines for name, lines in wrong.items() if lines} == {}
    assert find_writes(ROOT / "service" / "jobs.py"), "the reader of writes must see some"


def test_the_groups_of_states_cover_them_once():
    """Broken where a new state belongs to no group, so that a worker goes home while a job of it waits."""
    assert OPEN | ENDED == set(State) and not OPEN & ENDED and UNSUCCESSFUL == ENDED - {State.SUCCEEDED}
    assert set(TRANSITIONS) == set(State)
    assert all(TRANSITIONS[state] <= OPEN - {State.RUNNING} for state in ENDED), "only a retry leaves an end"


@pytest.mark.parametrize(("source", "to"), list(product(State, State)))
def test_no_move_but_those_of_the_table(source, to):
    """Broken where `change_state` lets a job go where the table does not, an ended job to running, say."""
    row = JobRow(id="0" * 12, state=source, attempts=1)

    class Events:
        added: list[object] = []  # noqa: RUF012

        def add(self, one: object) -> None:
            self.added.append(one)

        def scalars(self, asked: object) -> Events:
            return self

        def all(self) -> list[object]:
            return []  # nobody wants to be told

    if to in TRANSITIONS[source]:
        change_state(Events(), row, to, "moved")
        assert row.state is to
    else:
        with pytest.raises(MoveForbidden):
            change_state(Events(), row, to, "moved")
        assert row.state is source


def test_a_claim_moves_from_running_only(database, queue_job):
    """Broken where a worker's claim could take a move that its running job does not have."""
    held = claim(database, queue_job(), "a", 30.0)
    with pytest.raises(MoveForbidden), database.write() as session:
        change_state(session, held, State.RUNNING, "moved")
