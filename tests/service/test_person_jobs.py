"""The kind `person`: a job for each garment that is worn, and what is kept where nothing can be recovered."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from garmentq.cli.person_summary import describe_person
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.recover.settings import RecoverySettings
from garmentq.service.families import retry
from garmentq.service.jobs import Claim, find_job, read_events
from garmentq.service.kinds import FileRef, pack_request, read_request
from garmentq.service.kinds.person_request import ChoiceAmbiguous, PartChoice, PersonRequest, make_person
from garmentq.service.kinds.recover import Recover
from garmentq.service.kinds.recover_request import RecoverRequest
from garmentq.service.kinds.request import RequestBad
from garmentq.service.pages.words import describe_worn
from garmentq.service.results import export_files, list_files, report_jobs
from garmentq.service.services import Services
from garmentq.service.settings import CHECKER
from garmentq.service.states import State
from garmentq.service.submission import Order, SubmissionResult, submit
from garmentq.workers.recovery import unpack
from garmentq_family_home import PERSONS, pieces, work_off
from garmentq_home import put_file

FILE, OTHER = FileRef("a" * 64, "mine.json"), FileRef("b" * 64, "yours.json")


@pytest.fixture(scope="session", params=["sqlite", pytest.param("postgresql", marks=pytest.mark.nightly)])
def database_kind(request):
    """Choose SQLite; what a person adds to the tables is killed on both databases in the chaos tests."""
    return request.param


def test_each_garment_is_a_job(queue_person, persons, settings, database, store, tmp_path):
    """Breaks where a garment is lost, reads another's part, or a choice reaches the wrong one."""
    choices = {"upper": PartChoice(fabric="denim"), "lower": PartChoice(template="trousers", garment="trousers")}
    common = RecoverySettings(seed=7, lock="fabric", units="cm")
    root = queue_person(choices=choices, settings=common)
    work_off(persons, database)
    found = pieces(database, root)
    assert sorted(found) == ["lower", "upper"] and {row.kind for row in found.values()} == {"recover"}
    assert {row.state for row in found.values()} == {"succeeded"}
    for word, row in found.items():
        request = read_request(RecoverRequest, row.request)
        assert request.part == word and request.scan is None and request.settings.seed == 7
        assert request.settings.lock == "fabric"
    assert found["upper"].request["settings"]["fabric"] == "denim"
    assert found["lower"].request["settings"]["fabric"] is None
    assert found["lower"].request["settings"]["template"] == "trousers"
    (told,) = report_jobs(database, [found["upper"]], settings)
    assert told.metrics["confidence"] == 0.97
    (told,) = report_jobs(database, [find_job(database, root)], settings)
    assert told.body == "mesh:standin" and told.metrics["confidence.upper"] == 0.97
    assert [one["part"] for one in told.details["garments"]] == ["upper", "lower"]
    paths = export_files(database, store, root, tmp_path / "out")
    names = sorted(path.relative_to(tmp_path / "out").as_posix() for path in paths)
    assert names == ["labels.npz", "lower/reading.npz", "person.json", "report.html", "upper/reading.npz"]


def test_a_garment_reads_its_own_part_alone(queue_person, persons, settings, database, store, tmp_path):
    """Breaks where a garment's job copies the pictures, reports and readings of all the person."""
    root = queue_person()
    work_off(persons, database)
    child = pieces(database, root)["lower"]
    held = Claim(child.id, child.fence, "me", 1, child.request, child.name, child.kind, {"person": root})
    request = read_request(RecoverRequest, child.request)
    work = unpack(Services(settings, database, store), held, tmp_path / "work", Recover(), request)
    read = sorted(path.relative_to(work.inputs["person"]).as_posix() for path in work.inputs["person"].rglob("*.*"))
    assert read == ["lower/reading.npz", "person.json"]


def test_who_is_unsure_keeps_what_there_is_to_see(queue_person, persons, database, store, settings):
    """Breaks where a doubtful result is recovered, or its labels and report are thrown away with it."""
    root = queue_person("unsure.ply")
    work_off(persons, database)
    row = find_job(database, root)
    assert (row.state, row.error_code, row.bad_input) == ("failed", "segment.unsure", True)
    assert pieces(database, root) == {}
    assert {"labels.npz", "report.html"} <= {file.name for file in list_files(database, root)}
    (told,) = report_jobs(database, [row], settings)
    assert told.warnings == ["this is a stand-in"] and told.details["garments"][0]["part"] == "upper"
    assert [event.kind for event in read_events(database, root)][-1] == "failed"
    retry(database, root)
    assert find_job(database, root).result is None
    work_off(persons, database)
    assert find_job(database, root).state == "failed" and list_files(database, root)


def test_what_is_sure_is_recovered_beside_what_is_not(queue_person, persons, database, settings):
    """Breaks where a doubtful garment stops the others' recovery, or is recovered, or nothing says why it is not."""
    root = queue_person("coat.ply")
    work_off(persons, database)
    row = find_job(database, root)
    assert row.state == "succeeded" and {name: one.state for name, one in pieces(database, root).items()} == {
        "lower": "succeeded"
    }
    (told,) = report_jobs(database, [row], settings)
    assert [garment.get("problem") is None for garment in told.details["garments"]] == [False, True]
    worn = dict(describe_worn(told.details["garments"]))
    assert "Not recovered: An outer layer" in worn["upper"] and "Not recovered" not in worn["lower"]
    assert "confidence 0.97, not recovered; lower" in dict(describe_person(told))["garments"]


def test_a_refusal_keeps_nothing(queue_person, persons, database):
    """Breaks where a job that was refused at once looks as if it had found something."""
    root = queue_person("bare.ply")
    work_off(persons, database)
    row = find_job(database, root)
    assert (row.state, row.error_code, list_files(database, root)) == ("failed", "segment.no_clothes", [])


def test_a_choice_of_one_garment_is_no_choice_of_two(queue_person, persons, database):
    """Breaks where one pattern is graded to both garments, or the refusal throws the labels away."""
    root = queue_person(settings=RecoverySettings(template="tshirt"))
    work_off(persons, database)
    row = find_job(database, root)
    assert (row.state, row.error_code, row.bad_input) == ("failed", "person.choice_ambiguous", True)
    assert "upper and lower" in row.error_message and "--template upper:tshirt" in row.error_message
    assert list_files(database, root) and pieces(database, root) == {}
    root = queue_person("dress.ply", settings=RecoverySettings(template="dress", garment="dress"))
    work_off(persons, database)
    (child,) = pieces(database, root).values()
    assert (child.name, child.request["settings"]["template"]) == ("one-piece", "dress")


@pytest.mark.parametrize(
    ("given", "words", "found"),
    [
        ({}, "upper lower", {"upper": PartChoice(), "lower": PartChoice()}),
        ({"template": FILE}, "lower", {"lower": PartChoice(template=FILE)}),
        ({"template": FILE, "choices": {"upper": PartChoice(template=OTHER)}}, "upper lower",
         {"upper": PartChoice(template=OTHER), "lower": PartChoice(template=FILE)}),
        ({"settings": RecoverySettings(lock="fabric,symmetry")}, "upper lower",
         {"upper": PartChoice(lock="fabric,symmetry"), "lower": PartChoice(lock="fabric,symmetry")}),
        ({"settings": RecoverySettings(lock="panel:front")}, "upper lower", None),
        ({"settings": RecoverySettings(fabric="denim")}, "upper lower", None),
        ({"settings": RecoverySettings(garment="skirt")}, "upper lower", None),
        ({"settings": RecoverySettings(garment="skirt")}, "lower", {"lower": PartChoice(garment="skirt")}),
    ],
)  # fmt: skip
def test_what_is_meant_by_a_choice_without_a_part(given, words, found):
    """Breaks where a plain choice overrules a garment's own, or is taken for several garments."""
    request = PersonRequest(FILE, **given)
    if found is None:
        with pytest.raises(ChoiceAmbiguous):
            request.choose(words.split())
    else:
        assert request.choose(words.split()) == found


def test_requests_come_back_from_json():
    """Breaks where a choice, or a file in it, is another after it was stored."""
    request = PersonRequest(
        FILE, labels=OTHER, body=BuiltinWearer("builtin:female"), marks=("upper=1,2,3",), given_as="person",
        choices={"upper": PartChoice(template=FILE), "lower": PartChoice(template="skirt")},
    )  # fmt: skip
    stored = json.loads(json.dumps(pack_request(request)))
    assert read_request(PersonRequest, stored) == request
    assert request.templates == {"upper": FILE} and request.place("upper") == "choices/upper/template"
    for bad in ({"hat": PartChoice()}, {"skin": PartChoice()}):
        with pytest.raises(RequestBad):
            PersonRequest(FILE, choices=bad)
    for bad in (RecoverRequest, lambda *given: RecoverRequest(*given, part="../x")):
        with pytest.raises(RequestBad):
            bad(None, None, None)
    turned = make_person(RecoverRequest(FILE, OTHER, OTHER, RecoverySettings(seed=3), OTHER))
    assert turned == PersonRequest(FILE, RecoverySettings(seed=3), OTHER, OTHER, OTHER)


def test_labels_with_names_are_of_a_person(settings, database, store, tmp_path):
    """Breaks where a corrected labels file is taken for one garment's, or becomes another job."""
    labels = tmp_path / "labels.npz"
    np.savez(labels, label=np.zeros(3, np.uint8), names=np.array(["skin"]))
    scan = put_file(tmp_path, "anna.ply")
    asked = submit(database, store, Order(scan, None, labels=labels))
    assert find_job(database, asked.job).kind == "recover"
    work_off(replace(settings, **PERSONS, checker=CHECKER), database)
    row = find_job(database, asked.job)
    assert (row.kind, row.state, row.attempts) == ("person", "succeeded", 1) and len(pieces(database, row.id)) == 2
    assert read_request(PersonRequest, row.request).labels.name == "labels.npz"
    assert "understood" in [event.kind for event in read_events(database, row.id)]
    assert submit(database, store, Order(scan, None, labels=labels)) == SubmissionResult(
        asked.job, False, State.SUCCEEDED
    )
    kept = submit(database, store, Order(scan, None, labels=labels, settings=RecoverySettings(keep="0")))
    assert kept.is_new and find_job(database, kept.job).kind == "recover"


def test_a_choice_that_fits_two_is_refused_at_once(database, store, tmp_path):
    """Breaks where a job is queued that is sure to end as ambiguous: who names two garments has to say whose it is."""
    scan = put_file(tmp_path, "anna.ply")
    order = Order(scan, None, wearing="upper, lower", settings=RecoverySettings(template="tshirt"))
    with pytest.raises(ChoiceAmbiguous):
        submit(database, store, order)
    assert submit(database, store, replace(order, wearing="upper")).is_new


def test_an_old_request_is_as_it_was():
    """Breaks where the hash of an order of an earlier version changes: its result would be computed anew."""
    packed = pack_request(RecoverRequest(FILE, BuiltinWearer("builtin:female"), None))
    assert sorted(packed) == ["body", "scan", "settings", "template"]
