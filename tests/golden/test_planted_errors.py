"""The list of errors that the gate is measured with fits the tree: each can be planted, in sound code."""

from __future__ import annotations

import ast
import json
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

LIST = runpy.run_path(str(ROOT / "benchmarks" / "planted_errors.py"))

COUNTS = {"width": 8, "seam": 4, "metric": 8, "body": 4, "stiffness": 6, "threshold": 6, "delivery": 4}
"""Errors of each kind."""


def test_there_are_forty_under_different_names():
    """Broken where an error is added or lost, or two cannot be told apart in a table."""
    kinds = [error.kind for error in LIST["ERRORS"]]
    assert {str(kind): kinds.count(kind) for kind in LIST["ErrorKind"]} == COUNTS
    assert len({error.name for error in LIST["ERRORS"]}) == sum(COUNTS.values()) == 40


@pytest.mark.parametrize("error", LIST["ERRORS"], ids=lambda error: error.name)
def test_an_error_changes_one_place_of_sound_code(error):
    """Broken where the code that an error changes is written anew, or the error is a slip that nothing can run."""
    before = (ROOT / error.path).read_text(encoding="utf-8")
    after = error.plant(before)
    assert error.path.startswith(("core/", "cli/bench/")) and before.count(error.old) == 1 and after != before
    if error.path.endswith(".json"):
        assert json.loads(after) != json.loads(before)
    else:
        assert ast.dump(ast.parse(after)) != ast.dump(ast.parse(before))
    assert all(f"{word} = " in error.old or f"\n{word} = " in before for word in error.words)


@pytest.mark.parametrize("source", ["x = 3", "x = 1; x = 1"])
def test_an_error_whose_place_is_not_there_once_is_refused(source):
    """Broken where an error that changes nothing, or two places, would count as one that the gate has let through."""
    error = LIST["PlantedError"](LIST["ErrorKind"].SEAM, "any", "core/any.py", "x = 1", "x = 2")
    with pytest.raises(LIST["PlantFault"], match=r"core/any\.py holds"):
        error.plant(source)
