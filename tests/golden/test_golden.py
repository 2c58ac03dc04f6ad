"""Ten scenes measure what was accepted of them; the record says how far each number may be off and why it is what it
is.

A change that is meant to move a number is accepted with its reason: `make accept REASON="..."`.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from garmentq.workers.kernels import read_table
from golden_numbers import Measured
from golden_record import accept, compare, describe_scatter, load_record, widen
from golden_scenes import SCENES, SCENES_FOLDER, Shift, list_provenance
from kernel_calls import record_calls

MOST_BYTES = 15 * 1024**2
"""Of all inputs of the scenes."""

LEAST_NUMBERS = 20
"""Of each scene."""


@pytest.mark.parametrize("name", sorted(SCENES))
def test_a_scene_measures_what_was_accepted(name):
    """Broken where a constant, a formula or a step drifts: of pattern, fabric, mesh, wearer, labels, gate or export; or
    where a kernel that the scene calls is not compiled ahead."""
    with record_calls() as calls:
        wrong = compare(name, load_record()["scenes"][name], SCENES[name](Shift()))
    assert calls <= set(read_table()), "a call that is not in workers/kernels.json: make kernels"
    assert not wrong, "\n".join([*map(str, wrong), "where this is meant: make accept REASON='why'"])


def test_what_is_recorded_has_a_reason():
    """Broken where a scene is gone, measures next to nothing, or a number came in unexplained."""
    record = load_record()
    assert set(record["scenes"]) == set(SCENES)
    for entry in record["scenes"].values():
        assert len(entry["numbers"]) >= LEAST_NUMBERS
        assert all(np.isfinite([kept["value"], kept["tolerance"]]).all() for kept in entry["numbers"].values())
    assert {told["scene"] for told in record["history"]} == set(record["scenes"])
    assert all(told["reason"].strip() for told in record["history"])


def test_where_every_input_is_from_is_told():
    """Broken where a file of the scenes has no source, one is told of that is not there, or they grow beyond bounds."""
    files = {path.relative_to(SCENES_FOLDER).as_posix(): path for path in SCENES_FOLDER.rglob("*") if path.is_file()}
    told = list_provenance()
    assert set(told) == set(files) - {"provenance.json"}
    assert {each["licence"] for each in told.values()} <= {"CC0-1.0", "MIT", "Apache-2.0"}
    assert all(each["source"] for each in told.values())
    assert sum(path.stat().st_size for path in files.values()) <= MOST_BYTES


def test_what_scatters_may_be_off_by_that_and_a_word_that_does_is_not_held():
    """Broken where a scene's own noise fails it, or where a number that stays put may drift by percents."""
    runs = [
        Measured({"girth_cm": 80.0 + shift, "steady.area_cm2": 1000.0, "rare": 1.0}, {"cut": "a", "gate": word})
        for shift, word in ((0.0, "pass"), (0.3, "pass"), (-0.5, "doubtful"))
    ]
    runs[2] = Measured({name: value for name, value in runs[2].numbers.items() if name != "rare"}, runs[2].words)
    entry = json.loads(json.dumps(describe_scatter(runs)))
    assert entry["words"] == {"cut": "a"} and "rare" not in entry["numbers"]
    at = {name: kept["tolerance"] for name, kept in entry["numbers"].items()}
    assert at == {"girth_cm": pytest.approx(2.5), "steady.area_cm2": pytest.approx(2.0)}
    found = Measured({"girth_cm": 82.4, "steady.area_cm2": 1001.0}, {"cut": "a", "gate": "fail"})
    assert compare("x", entry, found) == []
    for numbers, words in (
        ({"girth_cm": 82.6, "steady.area_cm2": 1000.0}, {"cut": "a"}),
        ({"girth_cm": 80.0, "steady.area_cm2": 1003.0}, {"cut": "a"}),
        ({"girth_cm": float("nan"), "steady.area_cm2": 1000.0}, {"cut": "a"}),
        ({"girth_cm": 80.0}, {"cut": "a"}),
        ({"girth_cm": 80.0, "steady.area_cm2": 1000.0}, {"cut": "b"}),
        ({"girth_cm": 80.0, "steady.area_cm2": 1000.0}, {}),
    ):
        assert len(compare("x", entry, Measured(numbers, words))) == 1


def test_what_is_accepted_is_kept_with_old_value_and_reason():
    """Broken where the record forgets what a number was, or why it changed."""
    record = {"scenes": {}, "history": []}
    one, other = (describe_scatter([Measured({"a_cm": value}, {"cut": "x"})]) for value in (1.0, 2.0))
    assert accept(record, "s", one, "first") == ["s: a_cm None -> 1.0", "s: cut None -> x"]
    assert accept(record, "s", other, "wider") == ["s: a_cm 1.0 -> 2.0"]
    assert accept(record, "s", other, "again") == [] and record["scenes"]["s"] == other
    assert record["history"] == [
        {"scene": "s", "reason": "first", "changes": "new"},
        {"scene": "s", "reason": "wider", "changes": {"a_cm": [1.0, 2.0]}},
    ]


def test_another_machine_widens_what_is_allowed():
    """Broken where a run on another processor moves an accepted value, or leaves no trace of what it changed."""
    record = {"scenes": {"s": describe_scatter([Measured({"a_cm": 100.0, "b_cm": 5.0}, {"cut": "x"})])}, "history": []}
    found = Measured({"a_cm": 101.0, "b_cm": 5.0}, {"cut": "y"})
    assert len(widen(record, "s", found, "a processor of 2026")) == 2
    entry = record["scenes"]["s"]
    assert entry["numbers"]["a_cm"] == {"value": 100.0, "tolerance": 5.0} and entry["words"] == {}
    assert entry["numbers"]["b_cm"]["tolerance"] == pytest.approx(0.02)
    assert compare("s", entry, found) == [] and widen(record, "s", found, "again") == []
    assert [told["reason"] for told in record["history"]] == ["a processor of 2026"]
