"""A choice between alternatives takes the best, computes no more than it needs, and is reported."""

from __future__ import annotations

import json
import math

import pytest
from garmentq.core.run.best import choose_best
from garmentq.core.run.clock import Clock
from garmentq.core.run.finding import FindingKind, note
from garmentq.core.run.hooks import Hooks


def test_the_lowest_score_is_taken_and_all_are_reported() -> None:
    """Broken where a worse one is taken, or a result's manifest does not show what else was tried."""
    clock = Clock()
    scores = {"a": 0.25, "b": 0.123456, "c": math.inf}
    with clock.stage("fit", "choosing") as hooks:
        assert choose_best("start", {name: name for name in scores}, scores.__getitem__, hooks.quiet()) == "b"
    (found,) = clock.take_findings()
    assert found.kind is FindingKind.CHOICE and found.message == ""
    assert found.evidence == {"of": "start", "taken": "b", "scores": {"a": 0.25, "b": 0.1235, "c": None}}
    json.dumps(found.evidence, allow_nan=False)
    assert clock.take_findings() == ()


def test_the_first_of_equal_ones_is_taken() -> None:
    """Broken where a tie is decided by chance or by the name."""
    assert choose_best("start", {"z": 1, "a": 2}, lambda one: 0.5, Hooks()) == 1


def test_tuples_are_compared_by_their_first_difference() -> None:
    """Broken where a drape that is not at rest goes before one that is."""
    scores = {"fast": (1.0, 0.0), "at rest": (0.0, 9.0), "nearer": (0.0, 3.0)}
    assert choose_best("drape", {name: name for name in scores}, scores.__getitem__, Hooks()) == "nearer"


def test_one_alone_is_not_measured() -> None:
    """Broken where a score that takes seconds is computed for nothing, or a choice is reported that was none."""
    clock = Clock()
    assert choose_best("start", {"only": 7}, lambda one: pytest.fail("measured"), clock.hooks) == 7
    assert clock.take_findings() == ()
    with pytest.raises(ValueError, match="start"):
        choose_best("start", {}, lambda one: 0.0, clock.hooks)


def test_a_runs_own_hooks_hear_of_findings_no_more_than_once() -> None:
    """Broken where findings of one stage are handed out with the next one's."""
    clock = Clock()
    with clock.stage("grade", "grading") as hooks:
        hooks.report(note("the hem is frayed"))
    assert [one.message for one in clock.take_findings()] == ["the hem is frayed"]
    with clock.stage("drape", "draping") as hooks:
        hooks.report(note("it does not rest"))
    assert [one.message for one in clock.take_findings()] == ["it does not rest"]
